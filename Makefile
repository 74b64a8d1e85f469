# Development tasks. Each target builds only what has changed. Needs git, make and Python 3.11 or newer;
# `make run PYTHON=python3.13` names another Python.

PYTHON ?= python3
VENV := .venv
PY := $(VENV)/bin/python
PIP := $(PY) -m pip --disable-pip-version-check
NPM := $(abspath scripts/with_node.sh) npm
PIP_AUDIT ?= pip-audit
# Runs what failed once more, alone, and fails if it fails again.
RUN_TESTS := scripts/run_tests.sh $(PY)

# Stamps of the last successful installs.
RUN_STAMP := $(VENV)/.installed
DEV_STAMP := $(VENV)/.installed-dev
DOCS_STAMP := $(VENV)/.installed-docs
NPM_STAMP := frontend/node_modules/.installed
PAGE := server/web/static/index.html

DIST := dist

# Folders too, so that a deleted file is noticed.
PAGE_SOURCES := $(wildcard frontend/index.html frontend/*.ts frontend/*.json) \
	$(shell test -d frontend/src && find frontend/src frontend/public -print 2>/dev/null)

# Packages are installed uncompiled. Where nothing compiled is kept, every process compiles what it imports: 10 s of
# processor time for PyTorch, 8 s for the server.
unexport PYTHONDONTWRITEBYTECODE

.DEFAULT_GOAL := help
.DELETE_ON_ERROR:
.PHONY: help run dev dev-server dev-page environment frontend test test-unit test-postgres coverage test-e2e \
	screenshots test-frontend check lint format types imports migrations-check api api-check texts texts-check \
	wheel docs constraints audit bench faults clean

help: ## list the targets
	@awk -F ':.*## ' '/^[a-z0-9-]+:.*## /{printf "  make %-18s %s\n", $$1, $$2}' $(MAKEFILE_LIST)

run: environment frontend ## start Tril: server, worker and inference
	@exec $(VENV)/bin/tril up $(ARGS)

dev: ## start Tril and the page, both reloading on save
	@echo "For the page with hot reloading, open the address below with port 5173 in place of 8000."
	@$(MAKE) --no-print-directory --jobs 2 dev-server dev-page

dev-server: $(DEV_STAMP) frontend
	@exec $(VENV)/bin/watchfiles --filter python --sigint-timeout 20 \
		"$(VENV)/bin/tril up --no-browser $(ARGS)" cli migrations server trainer tril

dev-page: $(NPM_STAMP)
	@cd frontend && exec $(NPM) run dev

environment: $(RUN_STAMP) ## create the virtual environment

frontend: $(PAGE) ## build the page

test: test-frontend test-unit test-e2e ## run all tests

test-unit: $(DEV_STAMP) frontend ## run the Python tests that need no browser
	$(RUN_TESTS) -m "not e2e" --numprocesses auto --dist worksteal $(ARGS)

test-postgres: $(DEV_STAMP) ## run the same on PostgreSQL, with a server that the tests start
	$(PY) -m pytest -m "not e2e" --database postgresql --numprocesses auto --dist worksteal $(ARGS)

coverage: $(DEV_STAMP) ## run the same and print the coverage; processes that tests start don't count
	$(PY) -m pytest -m "not e2e" --numprocesses auto --dist worksteal \
		--cov=tril --cov=server --cov=trainer --cov=cli --cov-report=term:skip-covered $(ARGS)

# A file at a time in each process, as what a file shows takes seconds to make; tests/e2e/conftest.py says which files
# are begun first. With a third process, games and trainings wait for each other on two cores.
test-e2e: $(DEV_STAMP) frontend ## run the tests in a real browser
	$(RUN_TESTS) -m e2e --numprocesses 2 --dist loadfile --no-loadscope-reorder $(ARGS)

screenshots: $(DEV_STAMP) frontend ## take the pictures anew that the pages are compared to
	TRIL_RENEW_SCREENSHOTS=1 $(PY) -m pytest tests/e2e/test_screenshots.py -k looks_as_it_did $(ARGS)

test-frontend: $(NPM_STAMP) ## run the page's unit tests
	cd frontend && $(NPM) test

check: lint types imports migrations-check api-check texts-check ## run all checks other than tests

lint: $(DEV_STAMP) $(NPM_STAMP) ## lint and check the format of Python and TypeScript
	$(VENV)/bin/ruff check
	$(VENV)/bin/ruff format --check
	cd frontend && $(NPM) run lint
	cd frontend && $(NPM) run format:check

format: $(DEV_STAMP) $(NPM_STAMP) ## format Python and TypeScript
	$(VENV)/bin/ruff check --fix-only
	$(VENV)/bin/ruff format
	cd frontend && $(NPM) run format

types: $(DEV_STAMP) $(NPM_STAMP) ## check types of Python and TypeScript
	$(VENV)/bin/mypy
	cd frontend && $(NPM) run typecheck

imports: $(DEV_STAMP) ## check which package imports which
	$(VENV)/bin/lint-imports --no-logo

migrations-check: $(DEV_STAMP) ## check that migrations lead to the models
	scripts/check_migrations.sh $(VENV)/bin/alembic

api: $(RUN_STAMP) $(NPM_STAMP) ## regenerate the page's types of the HTTP API
	$(PY) -m server.openapi > frontend/openapi.json
	cd frontend && $(NPM) run generate

api-check: $(RUN_STAMP) $(NPM_STAMP) ## check that the page's types are current
	@$(PY) -m server.openapi | diff frontend/openapi.json - > /dev/null || \
		{ echo "frontend/openapi.json is not the API's description: run make api"; exit 1; }
	cd frontend && $(NPM) run generate -- --check

texts: $(NPM_STAMP) ## renew the page's catalogues of texts from its source
	cd frontend && $(NPM) run texts

texts-check: $(NPM_STAMP) ## check that the catalogues are current, and German for play and rank
	cd frontend && $(NPM) run texts:check

wheel: $(DEV_STAMP) frontend ## build the distribution into dist/
	rm -rf $(DIST)
	$(PY) -m build --no-isolation --outdir $(DIST)

docs: $(DOCS_STAMP) ## build the documentation into site/; warnings are errors
	$(VENV)/bin/sphinx-build --fail-on-warning --keep-going --jobs auto --quiet docs site

constraints: $(DOCS_STAMP) ## write the installed versions into constraints.txt
	@$(INSTALL) '.[dev,docs,node,postgres,s3]'
	@{ grep '^#' constraints.txt; $(PIP) freeze --all --exclude pip --exclude-editable | tr A-Z_ a-z- | \
		sed 's/+.*//; /^\(nvidia\|cuda\|triton\)/d' | LC_ALL=C sort -t = -k 1,1; } > $(VENV)/constraints.txt
	@mv $(VENV)/constraints.txt constraints.txt

# Not part of check: it needs the Internet, and its answer changes without a change here.
audit: $(RUN_STAMP) $(NPM_STAMP) ## look for known vulnerabilities of the pinned packages
	@scripts/audit.sh "$(PIP_AUDIT)" "$(NPM)"

bench: $(DEV_STAMP) ## run all benchmarks
	@for file in benchmarks/*/[a-z]*.py; do \
		name=$$(echo $${file%.py} | tr / .); \
		printf '\n%s\n' "$$name"; \
		$(PY) -m "$$name" || exit 1; \
	done

# Not part of bench: it takes hours.
faults: $(DEV_STAMP) ## hurt a running Tril by 200 faults and check that nothing acknowledged is lost
	$(PY) -m benchmarks.faults $(ARGS)

clean: ## remove everything built; the data folder stays
	rm -rf $(VENV) frontend/node_modules server/web/static $(DIST) site docs/api
	rm -rf .import_linter_cache .hypothesis .mypy_cache .pytest_cache .ruff_cache test-results
	find . -name __pycache__ -type d -prune -exec rm -rf {} +

$(PY):
	@scripts/create_venv.sh "$(PYTHON)" $(VENV)

# The build backend comes first, so that the pinned one builds the project.
# Modules are compiled as they are imported: most of PyTorch is not.
INSTALL = $(PIP) install --quiet --no-compile --constraint constraints.txt hatchling && \
	$(PIP) install --quiet --no-compile --constraint constraints.txt --no-build-isolation --editable

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
