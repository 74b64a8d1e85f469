# Everything there is to do with a clone of Tril. Each target builds only what changed.
# It needs git, make and Python 3.11 or newer; `make run PYTHON=python3.13` names another Python.

PYTHON ?= python3
VENV := .venv
PY := $(VENV)/bin/python
PIP := $(PY) -m pip --disable-pip-version-check
NPM := $(abspath scripts/with_node.sh) npm

# A stamp is as new as the last install that went well.
RUN_STAMP := $(VENV)/.installed
DEV_STAMP := $(VENV)/.installed-dev
DOCS_STAMP := $(VENV)/.installed-docs
NPM_STAMP := frontend/node_modules/.installed
PAGE := server/web/static/index.html

# Where the distribution goes.
DIST ?= dist

# What the page is built from; folders too, so that a deleted file is noticed.
PAGE_SOURCES := $(wildcard frontend/index.html frontend/*.ts frontend/*.json) \
	$(shell test -d frontend/src && find frontend/src frontend/public -print 2>/dev/null)

.DEFAULT_GOAL := help
.DELETE_ON_ERROR:
.PHONY: help run dev dev-server dev-page environment frontend test test-unit test-e2e test-frontend check lint \
	format types imports migrations-check api api-check wheel docs constraints bench clean

help: ## say what there is to make
	@awk -F ':.*## ' '/^[a-z0-9-]+:.*## /{printf "  make %-18s %s\n", $$1, $$2}' $(MAKEFILE_LIST)

run: environment frontend ## build what changed, then start server, worker and inference
	@exec $(VENV)/bin/tril up $(ARGS)

dev: ## the same, started again when Python files change, and the page with hot reloading
	@echo "For the page with hot reloading, open the address below with port 5173 in place of 8000."
	@$(MAKE) --no-print-directory --jobs 2 dev-server dev-page

dev-server: $(DEV_STAMP) frontend
	@exec $(VENV)/bin/watchfiles --filter python --sigint-timeout 20 \
		"$(VENV)/bin/tril up --no-browser $(ARGS)" cli migrations server trainer tril

dev-page: $(NPM_STAMP)
	@cd frontend && exec $(NPM) run dev

environment: $(RUN_STAMP) ## the virtual environment with what running needs

frontend: $(PAGE) ## the page, built

test: test-frontend test-unit test-e2e ## every test, in a real browser too

# One more at once than there are cores; whoever is idle takes over what others have left to do.
test-unit: $(DEV_STAMP) ## every test of the Python part that needs no browser
	$(PY) -m pytest -m "not e2e" --numprocesses auto --dist worksteal $(ARGS)

# One after the other: a game in a browser wants the machine for itself.
test-e2e: $(DEV_STAMP) frontend ## the tests in a real browser
	$(PY) -m pytest -m e2e $(ARGS)

test-frontend: $(NPM_STAMP) ## the tests of the page's own code
	cd frontend && $(NPM) test

check: lint types imports migrations-check api-check ## every check that is no test

lint: $(DEV_STAMP) $(NPM_STAMP) ## rules and formatting, Python and TypeScript
	$(VENV)/bin/ruff check
	$(VENV)/bin/ruff format --check
	cd frontend && $(NPM) run lint
	cd frontend && $(NPM) run format:check

format: $(DEV_STAMP) $(NPM_STAMP) ## bring Python and TypeScript files into shape
	$(VENV)/bin/ruff check --fix-only
	$(VENV)/bin/ruff format
	cd frontend && $(NPM) run format

types: $(DEV_STAMP) $(NPM_STAMP) ## strict types, Python and TypeScript
	$(VENV)/bin/mypy
	cd frontend && $(NPM) run typecheck

imports: $(DEV_STAMP) ## which part may import which
	$(VENV)/bin/lint-imports --no-logo

migrations-check: $(DEV_STAMP) ## an empty database migrates to exactly what the models say
	scripts/check_migrations.sh $(VENV)/bin/alembic

api: $(RUN_STAMP) $(NPM_STAMP) ## the page's types of the HTTP API, after a change of it
	$(PY) -m server.openapi > frontend/openapi.json
	cd frontend && $(NPM) run generate

api-check: $(RUN_STAMP) $(NPM_STAMP) ## the page's types are those of the HTTP API
	@$(PY) -m server.openapi | diff frontend/openapi.json - > /dev/null || \
		{ echo "frontend/openapi.json is not the API's description: run make api"; exit 1; }
	cd frontend && $(NPM) run generate -- --check

wheel: $(DEV_STAMP) frontend ## the distribution to install elsewhere, with the page in it
	rm -rf $(DIST)
	$(PY) -m build --no-isolation --outdir $(DIST)

docs: $(DOCS_STAMP) ## the documentation as a site, in ./site; broken links are errors
	$(VENV)/bin/sphinx-build --fail-on-warning --keep-going --jobs auto --quiet docs site

constraints: $(DOCS_STAMP) ## pin what is installed in constraints.txt
	@$(INSTALL) '.[dev,docs,node,postgres]'
	@{ grep '^#' constraints.txt; $(PIP) freeze --all --exclude pip --exclude-editable | tr A-Z_ a-z- | \
		sed 's/+.*//; /^\(nvidia\|cuda\|triton\)/d' | LC_ALL=C sort -t = -k 1,1; } > $(VENV)/constraints.txt
	@mv $(VENV)/constraints.txt constraints.txt

bench: $(DEV_STAMP) ## every benchmark, one after the other
	@for file in benchmarks/*/[a-z]*.py; do \
		name=$$(echo $${file%.py} | tr / .); \
		printf '\n%s\n' "$$name"; \
		$(PY) -m "$$name" || exit 1; \
	done

clean: ## remove what make built; the data folder stays
	rm -rf $(VENV) frontend/node_modules server/web/static $(DIST) site docs/api
	rm -rf .import_linter_cache .hypothesis .mypy_cache .pytest_cache .ruff_cache test-results
	find . -name __pycache__ -type d -prune -exec rm -rf {} +

# The environment is made once; an update installs what changed into it.
$(PY):
	@scripts/create_venv.sh "$(PYTHON)" $(VENV)

# The build backend comes first, so that the project is built with the pinned one.
INSTALL = $(PIP) install --quiet --constraint constraints.txt hatchling && \
	$(PIP) install --quiet --constraint constraints.txt --no-build-isolation --editable

$(RUN_STAMP): pyproject.toml constraints.txt | $(PY)
	@echo "Installing the Python packages (the first time takes minutes)"
	@$(INSTALL) .
	@touch $@

$(DEV_STAMP): $(RUN_STAMP)
	@echo "Installing the Python packages for tests and checks"
	@$(INSTALL) '.[dev]'
	@touch $@

$(DOCS_STAMP): $(DEV_STAMP)
	@$(INSTALL) '.[docs]'
	@touch $@

$(NPM_STAMP): frontend/package-lock.json frontend/package.json | $(PY)
	@echo "Installing the page's packages"
	@cd frontend && $(NPM) ci --no-fund --no-audit
	@touch $@

$(PAGE): $(NPM_STAMP) $(PAGE_SOURCES)
	@echo "Building the page"
	@cd frontend && $(NPM) run build
	@touch $@
