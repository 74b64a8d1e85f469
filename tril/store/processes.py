"""Which processes of Tril live."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import datetime, timedelta
from typing import Any

from sqlalchemy import delete, select
from sqlalchemy.orm import Session

from tril.store.changes import note_change
from tril.store.models import ProcessRow, now

ALIVE_FOR = timedelta(seconds=15)
"""A process that was not heard of for this long is not alive."""

FORGOTTEN_AFTER = timedelta(days=1)


@dataclass(frozen=True)
class ProcessStatus:
    """What is known of one process.

    Attributes:
        name: Unique name, e.g. "worker-0-3f9a2c1d".
        kind: "server", "worker" or "inference".
        alive: Whether it was heard of in the last 15 s.
        details: What it said about itself.
    """

    name: str
    kind: str
    alive: bool
    details: dict[str, Any]


def is_fresh(heartbeat_at: datetime | None) -> bool:
    """Whether a heartbeat is recent enough to count as a sign of life."""
    return heartbeat_at is not None and now() - heartbeat_at < ALIVE_FOR


def beat(session: Session, name: str, kind: str, details: dict[str, Any]) -> None:
    """Note that a process lives; tells the pages when it is new or says something new."""
    row = session.get(ProcessRow, name, with_for_update=True)
    if row is None:
        session.add(ProcessRow(name=name, kind=kind, details=details, heartbeat_at=now()))
        note_change(session, "system", name)
        return
    if row.details != details or not is_fresh(row.heartbeat_at):
        note_change(session, "system", name)
    row.kind, row.details, row.heartbeat_at = kind, details, now()


def leave(session: Session, name: str) -> None:
    """Note that a process has ended in good order, and forget those long gone."""
    session.execute(
        delete(ProcessRow).where(
            (ProcessRow.name == name) | (ProcessRow.heartbeat_at < now() - FORGOTTEN_AFTER)
        )
    )
    note_change(session, "system", name)


def statuses(session: Session) -> list[ProcessStatus]:
    """Return every process that was heard of lately, by name."""
    rows = session.scalars(
        select(ProcessRow)
        .where(ProcessRow.heartbeat_at > now() - FORGOTTEN_AFTER)
        .order_by(ProcessRow.name)
    )
    return [
        ProcessStatus(row.name, row.kind, is_fresh(row.heartbeat_at), row.details) for row in rows
    ]


def is_kind_alive(session: Session, kind: str) -> bool:
    """Whether a process of this kind was heard of in the last 15 s."""
    return any(status.alive for status in statuses(session) if status.kind == kind)
