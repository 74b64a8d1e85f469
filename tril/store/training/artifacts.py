"""The files of runs, which lie in the artifact store."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from sqlalchemy import select
from sqlalchemy.orm import Session

from tril.errors import NotFound
from tril.files.artifact_store import ArtifactStore
from tril.store.changes import note_change
from tril.store.database import Database
from tril.store.models import ArtifactRow, now


def folder_of(run_id: str) -> str:
    """Return the folder of a run's files in the artifact store."""
    return f"runs/{run_id}"


def path_of(run_id: str, name: str) -> str:
    """Return the path of a run's file in the artifact store."""
    return f"{folder_of(run_id)}/{name}"


def save(
    session: Session,
    run_id: str,
    kind: str,
    name: str,
    media_type: str,
    size_bytes: int,
    details: dict[str, Any] | None = None,
) -> ArtifactRow:
    """Add or replace the row of a file that lies in the artifact store."""
    row = find(session, run_id, name)
    if row is None:
        row = ArtifactRow(run_id=run_id, name=name)
        session.add(row)
    row.kind, row.path, row.media_type = kind, path_of(run_id, name), media_type
    row.size_bytes, row.details, row.created_at = size_bytes, details or {}, now()
    session.flush()
    note_change(session, "run", run_id)
    return row


def find(session: Session, run_id: str, name: str) -> ArtifactRow | None:
    """Return a run's file by name, if there is one."""
    return session.scalar(
        select(ArtifactRow).where(ArtifactRow.run_id == run_id, ArtifactRow.name == name)
    )


def of_kind(session: Session, run_id: str, kind: str) -> ArtifactRow:
    """Return the newest file of a kind; raises NotFound if the run has none yet."""
    row = session.scalar(
        select(ArtifactRow)
        .where(ArtifactRow.run_id == run_id, ArtifactRow.kind == kind)
        .order_by(ArtifactRow.created_at.desc(), ArtifactRow.id.desc())
        .limit(1)
    )
    if row is None:
        raise NotFound(f"This training has no {kind.replace('_', ' ')} yet.")
    return row


@contextmanager
def local_file(database: Database, store: ArtifactStore, run_id: str, kind: str) -> Iterator[Path]:
    """Give the newest file of a kind as a path on this machine.

    Raises:
        NotFound: The run has none yet.
    """
    with database.reading() as session:
        path = of_kind(session, run_id, kind).path
    with store.local(path) as file:
        yield file


def get(session: Session, artifact_id: int) -> ArtifactRow:
    """Return a file's row; raises NotFound if there is none."""
    row = session.get(ArtifactRow, artifact_id)
    if row is None:
        raise NotFound("There is no such file.")
    return row


def listing(session: Session, run_id: str) -> list[ArtifactRow]:
    """Return a run's files by kind and name."""
    query = select(ArtifactRow).where(ArtifactRow.run_id == run_id)
    return list(session.scalars(query.order_by(ArtifactRow.kind, ArtifactRow.name)))
