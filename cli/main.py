"""The ``tril`` command."""

from __future__ import annotations

import gc
import io
import os
import sys
from typing import Annotated

import typer
from typer import rich_utils

from cli.lazy import lazy_group
from cli.terminal import PlainConsole
from tril import __version__
from tril.files.private import UMASK

# Typer's errors quote arguments, such as the names of files.
setattr(rich_utils, "Console", PlainConsole)  # noqa: B010

COMMANDS = {
    "up": (
        "cli.commands.up:up",
        "Start server, worker and inference; print the address; Ctrl-C stops everything.",
    ),
    "demo": (
        "cli.commands.demo:demo",
        "Make demonstrations, rank them, train, evaluate, and write summary and pictures.",
    ),
    "train": (
        "cli.commands.runs:train",
        "Train an imitator and a clone on a behaviour's ranking.",
    ),
    "evaluate": (
        "cli.commands.evaluate:evaluate",
        "Play one game from each evaluation start with a trained policy; store nothing.",
    ),
    "reproduce": (
        "cli.commands.reproduce:reproduce",
        "Train what the ledger lacks, for each behaviour and training seed, and write the results.",
    ),
    "serve": (
        "cli.commands.services:serve",
        "Run only the web server (``tril up`` runs everything).",
    ),
    "worker": (
        "cli.commands.services:worker",
        "Run a training worker. Several may run at the same time, on any number of machines.",
    ),
    "inference": (
        "cli.commands.services:inference",
        "Run the inference process, which evaluates trained networks for the server.",
    ),
    "backup": (
        "cli.commands.backup:backup",
        "Back up databases and runs to a folder, also while Tril runs, and verify the copy.",
    ),
    "migrate": ("cli.commands.services:migrate", "Migrate the databases to this version."),
    "health": (
        "cli.commands.services:health",
        "Check a process of this data folder; exit with status 0 if it is healthy, else 1.",
    ),
    "status": (
        "cli.commands.services:status",
        "List the processes of Tril on all machines, with what workers learn on and are at.",
    ),
    "address": (
        "cli.commands.services:address",
        "Print the page's address with its key, e.g. for a server in a container.",
    ),
    "audit": ("cli.commands.people:audit", "Print who did what, the newest first."),
    "behaviours": ("cli.commands.behaviours:app", "The behaviours to teach."),
    "games": ("cli.commands.games:app", "The games that can be taught."),
    "recordings": ("cli.commands.recordings:app", "The library of recordings."),
    "runs": ("cli.commands.runs:app", "Training runs."),
    "gallery": (
        "cli.commands.share:gallery",
        "Write a page for each behaviour with a finished run, and index.html with a card for each.",
    ),
    "people": ("cli.commands.people:app", "Say who gets in."),
}
"""Where each command is, and the first line of its help."""

app = typer.Typer(
    cls=lazy_group(COMMANDS),
    name="tril",
    help="Teach a game agent by playing and ranking, without writing a reward function.",
    no_args_is_help=True,
    pretty_exceptions_show_locals=False,
)


def print_version(wanted: bool) -> None:
    """Print the version and exit, if it is wanted."""
    if wanted:
        typer.echo(f"tril {__version__}")
        raise typer.Exit


@app.callback()
def keep_private(
    version: Annotated[
        bool,
        typer.Option("--version", callback=print_version, is_eager=True, help="Print the version."),
    ] = False,
) -> None:
    """Teach a game agent by playing and ranking, without writing a reward function."""
    os.umask(UMASK)


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
    try:
        app()
    finally:
        # At the lowest priority the collection of all of PyTorch at exit takes seconds.
        gc.freeze()
