"""Trained networks, read back from the artifact store."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from tril.files.artifact_store import ArtifactStore
from tril.store.database import Database
from tril.store.training import artifacts


@contextmanager
def stored_file(database: Database, store: ArtifactStore, run_id: str, kind: str) -> Iterator[Path]:
    """Give the file of a run's artifact of a kind, as a path on this machine.

    Raises:
        NotFound: The run has none.
    """
    with database.reading() as session:
        path = artifacts.of_kind(session, run_id, kind).path
    with store.local(path) as file:
        yield file
