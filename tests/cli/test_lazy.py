"""Commands are imported when they are called."""

from __future__ import annotations

import gc
import subprocess
import sys
from importlib.metadata import version

import pytest
import typer

from cli.lazy import LazyCommand
from cli.main import COMMANDS
from cli.output import readable_errors
from cli.terminal import NO_MEMORY

HEAVY = ("sqlalchemy", "torch", "dbos", "fastapi", "numpy", "gymnasium")


@pytest.mark.parametrize("name", COMMANDS)
def test_the_help_says_of_each_command_what_it_says_itself(name: str) -> None:
    reference, summary = COMMANDS[name]
    itself = LazyCommand(name, reference, summary).command
    assert itself.name == name
    assert " ".join((itself.help or "").partition("\n\n")[0].split()) == summary


@pytest.mark.parametrize(
    "failure",
    [
        MemoryError(),
        ImportError("libtorch_cpu.so: failed to map segment from shared object"),
        ImportError("libx.so: cannot allocate memory in static TLS block"),
    ],
)
def test_too_little_memory_for_a_command_is_said_in_one_sentence(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], failure: Exception
) -> None:
    def refuse(_name: str) -> None:
        raise failure

    monkeypatch.setattr("cli.lazy.import_module", refuse)
    with pytest.raises(typer.Exit):
        LazyCommand("status", "cli.commands.services:status", "").make_context("status", [])
    assert capsys.readouterr().err == f"{NO_MEMORY}\n"


def test_a_module_that_is_missing_is_no_lack_of_memory() -> None:
    with pytest.raises(ModuleNotFoundError):
        LazyCommand("x", "cli.commands.nothing:x", "").make_context("x", [])
    assert gc.isenabled()


def test_too_little_memory_within_a_command_is_said_in_one_sentence(
    capsys: pytest.CaptureFixture[str],
) -> None:
    with pytest.raises(typer.Exit), readable_errors():
        raise MemoryError
    assert capsys.readouterr().err == f"{NO_MEMORY}\n"


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


def test_the_version_is_that_of_the_package() -> None:
    done = subprocess.run(
        [sys.executable, "-m", "cli", "--version"], capture_output=True, text=True, check=True
    )
    assert done.stdout == f"tril {version('tril-imitation')}\n"
