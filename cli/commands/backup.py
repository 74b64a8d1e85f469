"""``tril backup``: make and verify backups."""

from __future__ import annotations

from dataclasses import asdict
from datetime import datetime
from pathlib import Path
from typing import Annotated

import typer
from sqlalchemy.exc import DBAPIError

from cli.output import JsonOption, console, errors, print_json, read_settings, readable_errors
from tril.errors import Invalid
from tril.exchange.backup import Backup, check_backup, make_backup
from tril.settings import Settings
from tril.store import audit
from tril.store.database import create_database
from tril.text import printable


def backup(
    folder: Annotated[
        Path | None, typer.Argument(help="New folder. Default: backups/tril-DATE-TIME.")
    ] = None,
    check: Annotated[
        bool, typer.Option("--check", help="Verify an existing backup instead.")
    ] = False,
    as_json: JsonOption = False,
) -> None:
    """Back up databases and runs to a folder, also while Tril runs, and verify the copy.

    To work on the backup: TRIL_DATA=FOLDER tril up.
    """
    with readable_errors():
        if check:
            if folder is None:
                raise Invalid("Name the folder of the backup to verify.")
            result = check_backup(folder)
        else:
            now = datetime.now().astimezone()
            settings = read_settings()
            result = make_backup(settings, folder or Path("backups") / f"tril-{now:%Y%m%d-%H%M%S}")
            _note(settings, result)
    _report(result, "Backup verified" if check else "Backed up", as_json)


def _note(settings: Settings, result: Backup) -> None:
    """Log a backup. One of a database that can't be written any more is worth having, too."""
    database = create_database(settings.application_url)
    try:
        with database.writing() as session:
            folder = printable(str(result.folder))
            audit.note(session, audit.Action.BACKED_UP, None, "", folder=folder)
    except DBAPIError as error:
        errors.print(f"The backup is not in the audit log: {error.orig}.", style="yellow")
    finally:
        database.close()


def _report(result: Backup, label: str, as_json: bool) -> None:
    if as_json:
        print_json(asdict(result))
        return
    console.print(
        f"{label}: {result.folder}, {result.n_files} files, {result.size_bytes / 1e6:.1f} MB,"
        f" {result.n_recordings} recordings, {result.n_runs} runs."
    )
    for notice in result.notices:
        console.print(f"  {notice}")
