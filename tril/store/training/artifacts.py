"""The files of runs, which lie in the artifact store."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from sqlalchemy import select
from sqlalchemy.orm import Session

from tril.errors import NotFound, Unavailable
from tril.files.artifact_store import ArtifactStore
from tril.store.changes import note_change
from tril.store.database import Database
from tril.store.models import ArtifactRow, now


class ArtifactDamaged(Unavailable):
    """A file of a run whose content is not what was written.

    Attributes:
        run_id: The run.
        kind: Kind of the file.
    """

    def __init__(self, run_id: str, kind: str) -> None:
        super().__init__(
            f"A file of this training, its {kind.replace('_', ' ')}, was damaged after it had been"
            " written. Check the disk, and take the file from a backup or train again."
        )
        self.run_id, self.kind = run_id, kind


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
    sha256: str | None = None,
) -> ArtifactRow:
    """Add or replace the row of a file that lies in the artifact store.

    Args:
        session: The transaction.
        run_id: The run.
        kind: Kind of the artifact.
        name: Name of the artifact, unique in the run.
        media_type: Media type of the file.
        size_bytes: Size of the file.
        details: Describe it.
        sha256: Digest of the file, see ``digest``; None takes it for good whenever it is read.
    """
    row = find(session, run_id, name)
    if row is None:
        row = ArtifactRow(run_id=run_id, name=name)
        session.add(row)
    row.kind, row.path, row.media_type = kind, path_of(run_id, name), media_type
    row.size_bytes, row.details, row.created_at = size_bytes, details or {}, now()
    row.sha256 = sha256
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
        ArtifactDamaged: The content differs from what was written.
    """
    with database.reading() as session:
        row = of_kind(session, run_id, kind)
    with local(store, row) as file:
        yield file


@contextmanager
def local(store: ArtifactStore, row: ArtifactRow) -> Iterator[Path]:
    """Give a file as a path on this machine; raises ArtifactDamaged if its content has changed."""
    with store.local(row.path) as file:
        if row.sha256 is not None:
            _check(row, file.read_bytes())
        yield file


def read(store: ArtifactStore, row: ArtifactRow) -> bytes:
    """Return a file's content; raises ArtifactDamaged if it is not what was written."""
    content = store.get(row.path)
    _check(row, content)
    return content


def digest(content: bytes) -> str:
    """Return the digest of a file's content, 64 hexadecimal digits of SHA-256."""
    return hashlib.sha256(content).hexdigest()


def _check(row: ArtifactRow, content: bytes) -> None:
    # Files of earlier versions have no digest.
    if row.sha256 is not None and digest(content) != row.sha256:
        raise ArtifactDamaged(row.run_id, row.kind)


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
