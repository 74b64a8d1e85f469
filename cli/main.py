"""The ``tril`` command."""

from __future__ import annotations

import io
import os
import sys

import typer
from typer import rich_utils

from cli.commands import behaviours, games, people, recordings, runs, services
from cli.commands.backup import backup
from cli.commands.demo import demo
from cli.commands.evaluate import evaluate
from cli.commands.reproduce import reproduce
from cli.commands.up import up
from cli.output import PlainConsole
from tril.files.private import UMASK

# Typer's errors quote arguments, such as the names of files.
setattr(rich_utils, "Console", PlainConsole)  # noqa: B010

app = typer.Typer(
    name="tril",
    help="Teach a game agent by playing and ranking, without writing a reward function.",
    no_args_is_help=True,
    pretty_exceptions_show_locals=False,
)


@app.callback()
def keep_private() -> None:
    """Teach a game agent by playing and ranking, without writing a reward function."""
    os.umask(UMASK)


app.command()(up)
app.command()(demo)
app.command()(runs.train)
app.command()(evaluate)
app.command()(reproduce)
app.command()(services.serve)
app.command()(services.worker)
app.command()(services.inference)
app.command()(backup)
app.command()(services.migrate)
app.command()(services.health)
app.command()(services.status)
app.command()(services.address)
app.command()(people.audit)

app.add_typer(behaviours.app, name="behaviours")
app.add_typer(games.app, name="games")
app.add_typer(recordings.app, name="recordings")
app.add_typer(runs.app, name="runs")
app.add_typer(people.app, name="people")


def main() -> None:
    """Run the installed command, whose child processes import nothing from the current folder."""
    os.environ["PYTHONSAFEPATH"] = "1"
    run()


def run() -> None:
    """Run the command, with escapes for what the terminal or the file it prints to can't show."""
    # Where they are closed.
    sys.stdout = sys.stdout or open(os.devnull, "w", encoding="utf-8")  # noqa: SIM115
    sys.stderr = sys.stderr or open(os.devnull, "w", encoding="utf-8")  # noqa: SIM115
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")
    app()
