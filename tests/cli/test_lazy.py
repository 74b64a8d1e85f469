"""Commands are imported when they are called."""

from __future__ import annotations

import subprocess
import sys

import pytest

from cli.lazy import LazyCommand
from cli.main import COMMANDS

HEAVY = ("sqlalchemy", "torch", "dbos", "fastapi", "numpy", "gymnasium")


@pytest.mark.parametrize("name", COMMANDS)
def test_the_help_says_of_each_command_what_it_says_itself(name: str) -> None:
    reference, summary = COMMANDS[name]
    itself = LazyCommand(name, reference, summary).command
    assert itself.name == name
    assert " ".join((itself.help or "").partition("\n\n")[0].split()) == summary


def test_the_help_imports_nothing_of_what_commands_need() -> None:
    told = subprocess.run(
        [sys.executable, "-X", "importtime", "-m", "cli", "--help"],
        capture_output=True,
        text=True,
        check=True,
    )
    assert "Train an imitator" in told.stdout
    imported = {line.rpartition("|")[2].strip() for line in told.stderr.splitlines()}
    assert "typer" in imported
    assert not imported.intersection(HEAVY)
