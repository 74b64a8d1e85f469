"""The finished run that ships with Tril."""

from __future__ import annotations

from pathlib import Path

from tril.errors import NotFound
from tril.exchange.run_archive import read_archive
from tril.exchange.run_transfer import RunImportResult, import_run
from tril.files.artifact_store import ArtifactStore
from tril.store.database import Database

EXAMPLE = Path(__file__).with_name("column-1.zip")
BEHAVIOUR_NAME = "Example: column 1"


def has_example() -> bool:
    """Whether a finished run ships with this installation."""
    return EXAMPLE.is_file()


def open_example(
    database: Database, store: ArtifactStore, player_id: int | None = None
) -> RunImportResult:
    """Import the run that ships with Tril, into a behaviour of its own.

    Its recordings were verified when it was exported, and the tests replay them, so they are not
    replayed again. It is imported once; opened again, it is restored if it was deleted.

    Raises:
        NotFound: None ships with this installation.
        NameTaken: It was deleted, and another behaviour has its name by now.
    """
    if not has_example():
        raise NotFound("No finished example ships with this installation.")
    archive = read_archive(EXAMPLE)
    return import_run(
        database, store, archive, name=BEHAVIOUR_NAME, trusted=True, player_id=player_id
    )
