"""The floors of the house: which part may import which, and that a breach is noticed."""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PACKAGES = ("tril", "server", "trainer", "cli", "testsupport", "benchmarks")


def lint_imports(folder: Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [str(Path(sys.executable).parent / "lint-imports"), "--no-logo", "--no-cache"],
        cwd=folder,
        env={"PYTHONPATH": str(folder)},
        capture_output=True,
        text=True,
        check=False,
    )


@pytest.fixture(scope="module")
def copy(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a copy of the project that may be changed."""
    folder = tmp_path_factory.mktemp("house")
    for package in PACKAGES:
        shutil.copytree(ROOT / package, folder / package, ignore=shutil.ignore_patterns("*.pyc"))
    shutil.copy(ROOT / "pyproject.toml", folder)
    return folder


def test_every_part_imports_only_from_the_floors_below_it() -> None:
    done = lint_imports(ROOT)
    assert done.returncode == 0, done.stdout


@pytest.mark.parametrize(
    ("package", "line"),
    [
        ("tril", "import torch"),
        ("tril", "import fastapi"),
        ("tril", "import server.api"),
        ("server", "import stable_baselines3"),
        ("server", "import trainer.progress"),
        ("trainer", "import starlette"),
        ("trainer", "import server.api"),
        ("tril/game", "import tril.store.models"),
        ("benchmarks", "import tests.conftest"),
    ],
)
def test_a_breach_is_noticed(copy: Path, package: str, line: str) -> None:
    planted = copy / package / "planted.py"
    planted.write_text(f'"""A breach."""\n\n{line}\n')
    try:
        done = lint_imports(copy)
    finally:
        planted.unlink()
    assert done.returncode == 1, done.stdout
    assert "BROKEN" in done.stdout
    assert "planted" in done.stdout
