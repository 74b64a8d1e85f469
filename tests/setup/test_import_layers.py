"""Imports across the packages' borders are found by ``make imports``."""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PACKAGES = ("tril", "server", "trainer", "cli", "testsupport", "benchmarks")
BREACHES = (
    ("tril", "torch"),
    ("tril", "fastapi"),
    ("tril", "server.api"),
    ("tril.games.space_invaders", "tril.store.models"),
    ("server", "stable_baselines3"),
    ("server", "trainer.progress"),
    ("trainer", "starlette"),
    ("trainer", "server.api"),
    ("trainer.reward", "trainer.policy"),
    ("benchmarks", "tests"),
)


def test_every_breach_is_found(tmp_path: Path) -> None:
    for package in PACKAGES:
        shutil.copytree(ROOT / package, tmp_path / package, ignore=shutil.ignore_patterns("*.pyc"))
    shutil.copy(ROOT / "pyproject.toml", tmp_path)
    edges = []
    for number, (package, imported) in enumerate(BREACHES):
        planted = tmp_path / package.replace(".", "/") / f"planted_{number}.py"
        planted.write_text(f'"""A breach."""\n\nimport {imported}\n')
        edges.append(f"{package}.planted_{number} -> {imported}")
    done = subprocess.run(
        [Path(sys.executable).parent / "lint-imports", "--no-logo", "--no-cache"],
        cwd=tmp_path,
        env={"PYTHONPATH": str(tmp_path), "COLUMNS": "200"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert [edge for edge in edges if edge not in done.stdout] == [], done.stdout
