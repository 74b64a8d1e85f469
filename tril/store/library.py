"""A library in brief: what a page counts, filters and sorts by, and what changed since.

A library has tens of thousands of recordings, of which a page shows a few at a time. Their actions,
notes and conditions are not read here, and JSON is parsed by whoever needs it: in a library of
20,000 the objects would take most of the time, and the collection of garbage that they cause holds
up games.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import Any, Final

from sqlalchemy import ColumnElement, Text, cast, select
from sqlalchemy.orm import Session

from tril.games.base import Start
from tril.recording import Recording
from tril.store import rankings
from tril.store.changes import LIBRARY_CHANGED, newest_change, oldest_change
from tril.store.models import (
    BehaviourRow,
    ChangeRow,
    PlayerRow,
    RecordingRow,
    RecordingState,
    Source,
)

MAX_CHANGED = 1000
"""After more changes the whole library is read again."""

_IN_LIBRARY = (RecordingState.KEPT, RecordingState.UNFINISHED, RecordingState.FINISHED)

_COLUMNS: Final[tuple[Any, ...]] = (
    RecordingRow.id,
    RecordingRow.number,
    BehaviourRow.name.label("behaviour_name"),
    RecordingRow.source,
    PlayerRow.name.label("player"),
    RecordingRow.run_id,
    RecordingRow.parent_id,
    RecordingRow.parent_frame,
    RecordingRow.state,
    RecordingRow.verification,
    RecordingRow.n_frames,
    RecordingRow.end,
    cast(RecordingRow.taken, Text).label("taken"),
    cast(RecordingRow.counters, Text).label("counters"),
    RecordingRow.score,
    cast(RecordingRow.measured, Text).label("measured"),
    RecordingRow.perfect,
    RecordingRow.deleted_at.is_not(None).label("deleted"),
)
COLUMNS: Final = tuple(column.key for column in _COLUMNS)
"""Names of an entry's columns; ``taken``, ``counters`` and ``measured`` are JSON, unparsed."""

Entry = Any
"""A row of a recording in brief, with the columns above."""


@dataclass(frozen=True)
class Brief:
    """A library, a part of it, or what of it changed.

    Attributes:
        cursor: The newest change that it contains; later ones are those since.
        whole: Whether it is the whole library.
        entries: The recordings, newest first.
        removed: Recordings that changed and are not in the library, or not any more.
    """

    cursor: int
    whole: bool
    entries: Sequence[Entry]
    removed: Sequence[int]


def brief(
    session: Session,
    behaviour_id: int,
    *,
    since: int | None = None,
    before: int | None = None,
    limit: int | None = None,
    with_deleted: bool = False,
    only_of: int | None = None,
) -> Brief:
    """Return a behaviour's library in brief, games to keep or discard included.

    Args:
        session: The transaction.
        behaviour_id: The behaviour.
        since: Return only what changed after this cursor. Changes are kept for an hour; the whole
            library is returned if they are gone, or too many.
        before: Only recordings with lower ids; not of what changed.
        limit: At most so many, the newest; not of what changed.
        with_deleted: Whether to include deleted recordings.
        only_of: Only the games that this person played.
    """
    cursor = newest_change(session)
    where = [
        RecordingRow.behaviour_id == behaviour_id,
        RecordingRow.state.in_(_IN_LIBRARY),
        RecordingRow.run_id.is_(None),
    ]
    if not with_deleted:
        where.append(RecordingRow.deleted_at.is_(None))
    if only_of is not None:
        where += [RecordingRow.player_id == only_of, RecordingRow.source == Source.PERSON]
    changed = None if since is None else _changed(session, behaviour_id, since, cursor)
    if changed is None:
        if before is not None:
            where.append(RecordingRow.id < before)
        entries = _entries(session, *where, limit=limit)
        return Brief(cursor, before is None and len(entries) != limit, entries, [])
    entries = _entries(session, *where, RecordingRow.id.in_(changed)) if changed else []
    removed = changed - {entry.id for entry in entries}
    if only_of is not None and removed:
        # Nothing is told of other people's games, not even that they exist.
        own = select(RecordingRow.id).where(
            RecordingRow.id.in_(removed), RecordingRow.player_id == only_of
        )
        removed = set(session.scalars(own))
    return Brief(cursor, False, entries, sorted(removed))


def borrowed(session: Session, behaviour_id: int) -> Brief:
    """Return the games that a behaviour has borrowed, in brief, without deleted ones."""
    is_borrowed = RecordingRow.id.in_(rankings.borrowed_ids(behaviour_id))
    entries = _entries(session, is_borrowed, RecordingRow.deleted_at.is_(None))
    return Brief(newest_change(session), True, entries, [])


def shown(
    session: Session, behaviour_id: int, ids: Collection[int], only_of: int | None = None
) -> list[RecordingRow]:
    """Return those of some recordings that a behaviour's library has or has borrowed.

    Deleted ones are returned, too, and those that are neither are left out.

    Args:
        session: The transaction.
        behaviour_id: The behaviour.
        ids: The recordings.
        only_of: Only the games that this person played.
    """
    query = select(RecordingRow).where(
        RecordingRow.id.in_(ids),
        RecordingRow.state != RecordingState.PLAYING,
        (RecordingRow.behaviour_id == behaviour_id)
        | RecordingRow.id.in_(rankings.borrowed_ids(behaviour_id)),
    )
    if only_of is not None:
        query = query.where(RecordingRow.player_id == only_of, RecordingRow.source == Source.PERSON)
    return list(session.scalars(query.order_by(RecordingRow.id.desc())))


def same_games(
    session: Session, behaviour_id: int, played: Collection[Recording]
) -> dict[tuple[str, Start, bytes, str], int]:
    """Return the recordings of a library that may be among others, by what determines a game.

    That is the name of the game, the start, the actions and the game's version.
    """
    lengths = {recording.n_frames for recording in played}
    starts_of = {recording.game.name: recording.game.starts for recording in played}
    query = select(
        RecordingRow.id,
        RecordingRow.game,
        RecordingRow.start,
        RecordingRow.actions,
        RecordingRow.game_version,
    ).where(
        RecordingRow.behaviour_id == behaviour_id,
        RecordingRow.state.in_((RecordingState.KEPT, RecordingState.UNFINISHED)),
        RecordingRow.run_id.is_(None),
        RecordingRow.deleted_at.is_(None),
        RecordingRow.game.in_(starts_of),
        RecordingRow.n_frames.in_(lengths),
    )
    return {
        (row.game, starts_of[row.game].parse(row.start), row.actions, row.game_version): row.id
        for row in session.execute(query)
    }


def _entries(
    session: Session, *where: ColumnElement[bool], limit: int | None = None
) -> Sequence[Entry]:
    query = (
        select(*_COLUMNS)
        .join(BehaviourRow, BehaviourRow.id == RecordingRow.behaviour_id)
        .outerjoin(PlayerRow, PlayerRow.id == RecordingRow.player_id)
        .where(*where)
        .order_by(RecordingRow.id.desc())
        .limit(limit)
    )
    # Rows of the connection take half the time of the session's.
    return session.connection().execute(query).all()


def _changed(session: Session, behaviour_id: int, since: int, cursor: int) -> set[int] | None:
    """Return the recordings that changed since a cursor; None if they can't be told any more."""
    if not oldest_change(session) - 1 <= since <= cursor:
        return None
    newer = ChangeRow.id > since
    all_at_once = select(ChangeRow.id).where(
        newer, ChangeRow.topic == LIBRARY_CHANGED, ChangeRow.key == str(behaviour_id)
    )
    if session.scalar(all_at_once.limit(1)) is not None:
        return None
    keys = select(ChangeRow.key).where(newer, ChangeRow.topic == "recording").distinct()
    changed = set(session.scalars(keys.limit(MAX_CHANGED + 1)))
    return None if len(changed) > MAX_CHANGED else {int(key) for key in changed}
