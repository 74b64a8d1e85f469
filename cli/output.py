"""Output of the command line: rich text, JSON Lines, and errors without traceback."""

from __future__ import annotations

import errno
import json
import sqlite3
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Any

import typer
from pydantic import ValidationError
from rich.text import Text
from sqlalchemy.exc import DatabaseError

from cli.terminal import MORE_MEMORY, NO_MEMORY
from cli.terminal import console as console
from cli.terminal import errors as errors
from tril.errors import Invalid, TrilError
from tril.settings import Settings

JsonOption = Annotated[bool, typer.Option("--json", help="Print JSON.")]


def print_json(value: Any) -> None:
    """Print one JSON value on one line to standard output."""
    typer.echo(json.dumps(value, default=str))


@contextmanager
def readable_errors() -> Iterator[None]:
    """Print errors that the user can act on as one message; exit with status 1."""
    try:
        yield
    except (TrilError, DatabaseError, sqlite3.DatabaseError, OverflowError) as error:
        errors.print(Text.assemble(("Error:", "bold red"), f" {_message(error)}"))
        raise typer.Exit(1) from error
    except MemoryError as error:
        errors.print(NO_MEMORY)
        raise typer.Exit(1) from error
    except OSError as error:
        # What names no file failed within a command, and has to be known.
        advice = _ADVICE.get(error.errno or 0, _PLACE if error.filename else None)
        if advice is None:
            raise
        errors.print(Text.assemble(("Error:", "bold red"), f" {_failure_of(error)}. {advice}"))
        raise typer.Exit(1) from error


_PLACE = "Choose another place."
_FOLDER = "Let this user write there, or choose another data folder with TRIL_DATA."
_DISK = "Free some space on the disk, or choose another data folder with TRIL_DATA."
_FILES = "Let this process open more files (ulimit -n 1024), and start again."
_LOCKS = "Choose a data folder on a disk of this machine with TRIL_DATA."
_ADVICE = {
    errno.EROFS: _FOLDER,
    errno.EACCES: _FOLDER,
    errno.EPERM: _FOLDER,
    errno.ENOSPC: _DISK,
    errno.EDQUOT: _DISK,
    errno.EMFILE: _FILES,
    errno.ENFILE: _FILES,
    errno.ENOMEM: MORE_MEMORY,
    errno.ENOLCK: _LOCKS,
    errno.EOPNOTSUPP: _LOCKS,
    errno.ENOSYS: _LOCKS,
}
"""What to do about what the operating system refuses."""


def _failure_of(error: OSError) -> str:
    return f"{error.strerror}: {error.filename}" if error.filename else str(error.strerror)


def _message(error: TrilError | DatabaseError | sqlite3.DatabaseError | OverflowError) -> str:
    if isinstance(error, TrilError):
        return str(error)
    if isinstance(error, OverflowError):
        return "A number is too large."
    reason = error.orig if isinstance(error, DatabaseError) else error
    return (
        f"The database can't be used: {reason}. Check that the disk is not full and that the"
        " data folder (TRIL_DATA) is there."
        " If a database file is damaged, continue from a backup: TRIL_DATA=BACKUP-FOLDER tril up."
    )


def read_settings() -> Settings:
    """Read the settings from the environment.

    Raises:
        Invalid: A value is invalid; the message names its variable.
    """
    try:
        settings = Settings()
    except ValidationError as error:
        wrong = "; ".join(
            f"TRIL_{'_'.join(map(str, problem['loc'])).upper()}={problem['input']}:"
            f" {problem['msg']}"
            for problem in error.errors()
        )
        raise Invalid(f"Invalid settings in the environment or .env: {wrong}.") from error
    except (OSError, UnicodeDecodeError) as error:
        raise Invalid(f"The file .env in {Path.cwd()} can't be read: {error}.") from error
    if settings.data.exists() and not settings.data.is_dir():
        raise Invalid(f"TRIL_DATA is {settings.data}, which is not a folder. Choose another.")
    return settings


def print_process_line(name: str, line: str) -> None:
    """Print a line of a child process's output."""
    console.print(Text.assemble((f"{name:>9} │", "dim"), f" {line}"))
