"""The table of changes: the source of every event stream."""

from __future__ import annotations

import time
from collections.abc import Sequence
from datetime import timedelta

from sqlalchemy import delete, func, or_, select
from sqlalchemy.orm import Session

from tril.store.database import database_now
from tril.store.models import ChangeRow, RecordingRow

LATE_COMMIT_S = 120.0
"""Longest that a transaction is expected to take from noting a change to its commit."""
MAX_GAPS = 1000
"""Most ids that are waited for: what one transaction may note while others commit."""


MAX_NOTED_ONE_BY_ONE = 50
"""Recordings that change in one transaction are noted one by one up to so many."""
LIBRARY_CHANGED = "library"
"""Topic of a change of many recordings of a behaviour, whose id is the key."""


def note_change(session: Session, topic: str, key: str | int) -> None:
    """Note, in the transaction that changes it, that a thing changed.

    Args:
        session: The transaction.
        topic: Kind of thing: "run", "recording", "library", "ranking", "behaviour", "system".
        key: Id of the changed row.
    """
    session.add(ChangeRow(topic=topic, key=str(key), created_at=database_now(session)))


def note_recordings(session: Session, rows: Sequence[RecordingRow]) -> None:
    """Note, in the transaction that changes them, that recordings changed.

    Of many, their libraries are noted instead, so that no page is told of each.
    """
    if len(rows) <= MAX_NOTED_ONE_BY_ONE:
        for row in rows:
            note_change(session, "recording", row.id)
    else:
        for behaviour_id in sorted({row.behaviour_id for row in rows}):
            note_change(session, LIBRARY_CHANGED, behaviour_id)


class ChangeReader:
    """Reads every change once, from the time at which it is made.

    Ids are given out when a change is noted, not when it is committed: in PostgreSQL a change may
    appear after others with a higher id. Ids that are missing are therefore looked for until they
    appear or are too old, as those of transactions that were rolled back.

    Args:
        session: Sees the changes that are not read any more.
        late_commit_s: For how long a missing id is looked for.
    """

    def __init__(self, session: Session, late_commit_s: float = LATE_COMMIT_S) -> None:
        self._late_commit_s = late_commit_s
        self._missing: dict[int, float] = {}
        self._last = newest_change(session)
        first = max(0, self._last - MAX_GAPS)
        ids = set(session.scalars(select(ChangeRow.id).where(ChangeRow.id > first)))
        self._note_missing(set(range(first + 1, self._last)) - ids)

    def read(self, session: Session, limit: int = MAX_GAPS) -> list[ChangeRow]:
        """Return at most so many changes that were not read yet, in the order of their ids."""
        time_s = time.monotonic()
        self._missing = {key: until for key, until in self._missing.items() if until > time_s}
        is_new = or_(ChangeRow.id > self._last, ChangeRow.id.in_(self._missing))
        query = select(ChangeRow).where(is_new).order_by(ChangeRow.id).limit(limit)
        rows = list(session.scalars(query))
        ids = {row.id for row in rows}
        last = max(ids | {self._last})
        for key in ids & self._missing.keys():
            del self._missing[key]
        self._note_missing(set(range(max(self._last + 1, last - MAX_GAPS), last)) - ids)
        self._last = last
        return rows

    def _note_missing(self, ids: set[int]) -> None:
        self._missing |= dict.fromkeys(ids, time.monotonic() + self._late_commit_s)


def prune(session: Session, keep: timedelta = timedelta(hours=1)) -> None:
    """Delete changes that every stream has passed on long ago.

    The newest stays, because SQLite gives ids again once the highest is gone.
    """
    is_old = ChangeRow.created_at < database_now(session) - keep
    session.execute(delete(ChangeRow).where(is_old, ChangeRow.id < newest_change(session)))


def newest_change(session: Session) -> int:
    """Return the id of the newest change; 0 if there is none."""
    return session.scalar(select(func.max(ChangeRow.id))) or 0


def oldest_change(session: Session) -> int:
    """Return the id of the oldest change that is kept; 1 if there is none."""
    return session.scalar(select(func.min(ChangeRow.id))) or 1
