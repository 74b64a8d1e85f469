"""What make says and does around the project's own code."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
from pathlib import Path

import pytest

from tests.setup.programs import put_program
from tril.settings import Settings

ROOT = Path(__file__).resolve().parents[2]
SCRIPT = ROOT / "scripts/create_venv.sh"


@pytest.fixture
def project(tmp_path: Path) -> Path:
    """Return a folder that make takes for a built clone of the project."""
    clone = tmp_path / "clone"
    (clone / "frontend/src/pages").mkdir(parents=True)
    for name in ("Makefile", "pyproject.toml", "constraints.txt"):
        shutil.copy(ROOT / name, clone / name)
    for name in (
        "package.json",
        "package-lock.json",
        "index.html",
        "src/main.ts",
        "src/pages/a.ts",
    ):
        (clone / "frontend" / name).touch()
    for name in ("bin/python", "bin/tril", ".installed", ".installed-dev"):
        (clone / ".venv" / name).parent.mkdir(parents=True, exist_ok=True)
        (clone / ".venv" / name).touch()
    for name in ("node_modules/.installed", "../server/web/static/index.html"):
        (clone / "frontend" / name).parent.mkdir(parents=True, exist_ok=True)
        (clone / "frontend" / name).touch()
    for path in clone.rglob("*"):
        os.utime(path, (1_000_000, 1_000_000))
    return clone


def steps(project: Path, target: str = "run") -> str:
    """Return the commands that make would run."""
    return make(project, "--dry-run", target)


def make(project: Path, *arguments: str) -> str:
    """Run make and return what it writes."""
    # These tests run under a make themselves, whose flags must not reach this one.
    environ = {k: v for k, v in os.environ.items() if k not in {"MAKEFLAGS", "MAKELEVEL", "ARGS"}}
    done = subprocess.run(
        ["make", *arguments],
        cwd=project,
        env=environ,
        capture_output=True,
        text=True,
        check=True,
    )
    return done.stdout


def change(path: Path) -> None:
    os.utime(path, (2_000_000, 2_000_000))


def test_a_second_start_builds_nothing(project: Path) -> None:
    assert steps(project).split() == ["exec", ".venv/bin/tril", "up"]


@pytest.mark.parametrize("name", ["pyproject.toml", "constraints.txt"])
def test_changed_packages_are_installed_and_the_page_is_left_alone(
    project: Path, name: str
) -> None:
    change(project / name)
    assert "pip --disable-pip-version-check install" in steps(project)
    assert "npm" not in steps(project)
    assert "'.[dev]'" not in steps(project)
    assert "'.[dev]'" in steps(project, "test-unit")


def test_a_changed_lock_file_installs_the_pages_packages_and_builds_it(project: Path) -> None:
    change(project / "frontend/package-lock.json")
    assert re.search(r"npm ci.*npm run build", steps(project), re.DOTALL)
    assert "install --quiet" not in steps(project)


@pytest.mark.parametrize("name", ["src/main.ts", "src/pages", "index.html"])
def test_a_changed_source_or_folder_only_builds_the_page(project: Path, name: str) -> None:
    change(project / "frontend" / name)
    assert "npm run build" in steps(project)
    assert "npm ci" not in steps(project)


def test_a_folder_without_an_environment_gets_one(project: Path) -> None:
    shutil.rmtree(project / ".venv")
    text = steps(project)
    assert "scripts/create_venv.sh" in text
    assert text.index("create_venv") < text.index("--editable .") < text.index("tril up")


def test_compiled_modules_are_kept_whatever_the_environment_asks_for(
    project: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PYTHONDONTWRITEBYTECODE", "1")
    tril = project / ".venv/bin/tril"
    put_program(tril.parent, "tril", 'echo "[$PYTHONDONTWRITEBYTECODE]"')
    os.utime(tril, (1_000_000, 1_000_000))
    assert make(project, "run").strip() == "[]"


def create_venv(python: str, search_path: Path, folder: Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [shutil.which("sh") or "sh", str(SCRIPT), python, str(folder)],
        env={"PATH": str(search_path)},
        capture_output=True,
        text=True,
        check=False,
    )


def test_a_missing_python_is_named(tmp_path: Path) -> None:
    done = create_venv("python3", tmp_path, tmp_path / "venv")
    assert done.returncode == 1
    assert "no 'python3' on the PATH" in done.stderr
    assert "make run PYTHON=" in done.stderr


def test_an_old_python_is_refused_with_its_version(tmp_path: Path) -> None:
    put_program(
        tmp_path, "python3", 'case "$2" in *join*) echo 3.9.2;; *version_info*) exit 1;; esac'
    )
    done = create_venv("python3", tmp_path, tmp_path / "venv")
    assert done.returncode == 1
    assert "Python 3.11 or newer is needed, but 'python3' is 3.9.2" in done.stderr


def test_a_python_without_venv_says_which_package_is_missing(tmp_path: Path) -> None:
    put_program(
        tmp_path, "python3", 'case "$2" in *join*) echo 3.11.2;; *ensurepip*) exit 1;; esac'
    )
    done = create_venv("python3", tmp_path, tmp_path / "venv")
    assert done.returncode == 1
    assert "apt-get install python3-venv" in done.stderr


def test_the_example_of_settings_names_every_setting_with_its_default(
    data_folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    text = (ROOT / ".env.example").read_text()
    shown = dict(re.findall(r"^# TRIL_([A-Z_]+)=(.*)$", text, re.MULTILINE))
    assert {name.lower() for name in shown} == set(Settings.model_fields)
    monkeypatch.delenv("TRIL_DATA")
    monkeypatch.delenv("TRIL_LEARNING_NICENESS")
    monkeypatch.delenv("TRIL_DATABASE_URL", raising=False)
    monkeypatch.chdir(data_folder)
    defaults = Settings().model_dump()
    for name, value in shown.items():
        monkeypatch.setenv(f"TRIL_{name}", value)
    assert Settings().model_dump() == defaults
