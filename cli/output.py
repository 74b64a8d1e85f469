"""How the command speaks: rich text for people, JSON lines for scripts, errors in plain words."""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Annotated, Any

import typer
from rich.console import Console
from rich.markup import escape
from sqlalchemy.exc import OperationalError

from tril.errors import TrilError

console = Console(highlight=False, soft_wrap=True)
errors = Console(stderr=True, highlight=False, soft_wrap=True)

JsonOption = Annotated[bool, typer.Option("--json", help="Print JSON for a script to read.")]


def print_json(value: Any) -> None:
    """Print one JSON value on one line to standard output."""
    typer.echo(json.dumps(value, default=str))


@contextmanager
def plain_errors() -> Iterator[None]:
    """Turn what a person can act on into one message and exit status 1."""
    try:
        yield
    except TrilError as error:
        errors.print(f"[bold red]Error:[/] {error}")
        raise typer.Exit(1) from error
    except OperationalError as error:
        errors.print(
            f"[bold red]Error:[/] The database can't be used: {error.orig}. Check the disk and the "
            "data folder (TRIL_DATA), then try again."
        )
        raise typer.Exit(1) from error


def say(name: str, line: str) -> None:
    """Print a line that a process said."""
    console.print(f"[dim]{name:>9} │[/] {escape(line)}", soft_wrap=True)
