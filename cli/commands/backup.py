"""``tril backup``: everything a person made, copied while Tril runs, and checked."""

from __future__ import annotations

from dataclasses import asdict
from datetime import datetime
from pathlib import Path
from typing import Annotated

import typer

from cli.output import JsonOption, console, plain_errors, print_json, read_settings
from tril.errors import Invalid
from tril.exchange.backup import Backup, check_backup, make_backup


def backup(
    folder: Annotated[
        Path | None, typer.Argument(help="A new folder; else backups/tril-DATE-TIME.")
    ] = None,
    check: Annotated[
        bool, typer.Option("--check", help="Check the backup that is in the folder.")
    ] = False,
    as_json: JsonOption = False,
) -> None:
    """Back up databases and trainings to a folder, also while Tril runs; the copy is checked.

    The folder can be worked on at once: TRIL_DATA=FOLDER tril up.
    """
    with plain_errors():
        if check:
            if folder is None:
                raise Invalid("Name the folder of the backup to check.")
            found = check_backup(folder)
        else:
            now = datetime.now().astimezone()
            found = make_backup(
                read_settings(), folder or Path("backups") / f"tril-{now:%Y%m%d-%H%M%S}"
            )
    _report(found, "The backup is whole" if check else "Backed up", as_json)


def _report(found: Backup, what: str, as_json: bool) -> None:
    if as_json:
        print_json(asdict(found))
        return
    console.print(
        f"{what}: {found.folder}, {found.n_files} files, {found.size_bytes / 1e6:.1f} MB,"
        f" {found.n_recordings} recordings, {found.n_runs} runs."
    )
    for notice in found.notices:
        console.print(f"  {notice}")
