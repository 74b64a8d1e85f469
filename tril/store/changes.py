"""What changed, in order: the source of every event stream."""

from __future__ import annotations

from datetime import timedelta

from sqlalchemy import delete, func, select
from sqlalchemy.orm import Session

from tril.store.models import ChangeRow, now


def note_change(session: Session, topic: str, key: str | int) -> None:
    """Note, in the transaction that changes it, that a thing changed.

    Args:
        session: The transaction.
        topic: Kind of thing: "run", "recording", "ranking", "behaviour", "system".
        key: Its id.
    """
    session.add(ChangeRow(topic=topic, key=str(key)))


def last_change(session: Session) -> int:
    """Return the id of the newest change, 0 if there is none."""
    return session.scalar(select(func.max(ChangeRow.id))) or 0


def changes_after(session: Session, change_id: int, limit: int = 1000) -> list[ChangeRow]:
    """Return the changes that came after one, oldest first."""
    query = select(ChangeRow).where(ChangeRow.id > change_id).order_by(ChangeRow.id).limit(limit)
    return list(session.scalars(query))


def prune(session: Session, keep: timedelta = timedelta(hours=1)) -> None:
    """Forget changes that every stream has long passed on.

    The newest stays, because SQLite gives ids again once the highest is gone.
    """
    old = ChangeRow.created_at < now() - keep
    session.execute(delete(ChangeRow).where(old, ChangeRow.id < last_change(session)))
