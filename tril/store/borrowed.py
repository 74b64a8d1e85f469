"""What a behaviour's ranking may hold beside its library: borrowed games.

A borrowed game is of another behaviour, or was played by a policy of any; it stays what it is, and
the borrowing behaviour's ranking may hold it. `tril.teaching.varied_games` adds many at once.
"""

from __future__ import annotations

from collections.abc import Collection

from sqlalchemy import select
from sqlalchemy.orm import Session

from tril.analysis.variety import Traits
from tril.errors import Conflict, NotFound
from tril.games import game_of
from tril.store import behaviours, rankings, recordings
from tril.store.changes import note_change
from tril.store.models import (
    BehaviourRow,
    BorrowedGameRow,
    RecordingRow,
)

N_LENGTHS = 3
"""Classes of length that borrowed games are spread over, each an equal part of a whole game."""


def listing(session: Session, behaviour_id: int) -> list[RecordingRow]:
    """Return the games that a behaviour has borrowed, the newest first, without deleted ones."""
    query = select(RecordingRow).where(
        RecordingRow.id.in_(rankings.borrowed_ids(behaviour_id)), RecordingRow.deleted_at.is_(None)
    )
    return list(session.scalars(query.order_by(RecordingRow.id.desc())))


def borrow(session: Session, behaviour_id: int, recording_ids: Collection[int]) -> None:
    """Borrow games, all or none; those that are borrowed already are passed over.

    Raises:
        NotFound: A recording does not exist.
        Conflict: One is in the behaviour's library, of a deleted behaviour, or can't be ranked;
            all such recordings are named.
    """
    rankings.lock(session, behaviour_id)
    held = set(session.scalars(rankings.borrowed_ids(behaviour_id)))
    rows = recordings.by_ids(session, recording_ids)
    if unknown := sorted(set(recording_ids) - rows.keys()):
        raise NotFound(f"There are no such recordings: {', '.join(map(str, unknown))}.")
    new = [row for key, row in sorted(rows.items()) if key not in held]
    refused = [
        f"{rankings.named(session, behaviour_id, row)} {reason}"
        for row in new
        if (reason := _borrow_refusal(session, behaviour_id, row)) is not None
    ]
    if refused:
        raise Conflict(f"Nothing was added to the ranking's games: {', '.join(refused)}.")
    session.add_all(BorrowedGameRow(behaviour_id=behaviour_id, recording_id=row.id) for row in new)
    session.flush()
    note_change(session, "ranking", behaviour_id)


def give_back(session: Session, behaviour_id: int, recording_id: int) -> None:
    """Give a borrowed game back, so that the ranking can't hold it any more.

    Raises:
        NotFound: It is not borrowed.
        Conflict: It is ranked.
    """
    newest = rankings.lock(session, behaviour_id)
    row = session.get(BorrowedGameRow, (behaviour_id, recording_id))
    title = recordings.get(session, recording_id).title
    if row is None:
        raise NotFound(f"{title} is not borrowed by this behaviour.")
    if recording_id in rankings.as_ranking(newest).items:
        raise Conflict(f"{title} is ranked. Take it off the board before you give it back.")
    session.delete(row)
    note_change(session, "ranking", behaviour_id)


def _borrow_refusal(session: Session, behaviour_id: int, row: RecordingRow) -> str | None:
    """Return why a behaviour can't borrow a recording, None if it can."""
    if row.behaviour_id == behaviour_id and row.run_id is None:
        return "is in the behaviour's library, so that it can be ranked already"
    if session.get_one(BehaviourRow, row.behaviour_id).deleted_at is not None:
        return "is of a deleted behaviour"
    if row.game != session.get_one(BehaviourRow, behaviour_id).game:
        return "is of another game"
    return rankings.ranking_refusal(row)


def borrowable(session: Session, behaviour_id: int) -> dict[int, Traits]:
    """Return the behaviour, source and class of length of what other libraries could lend."""
    game = game_of(behaviours.as_behaviour(session.get_one(BehaviourRow, behaviour_id)))
    max_frames = game.clock.max_frames
    query = (
        select(
            RecordingRow.id, RecordingRow.behaviour_id, RecordingRow.source, RecordingRow.n_frames
        )
        .join(BehaviourRow, BehaviourRow.id == RecordingRow.behaviour_id)
        .where(
            RecordingRow.behaviour_id != behaviour_id,
            RecordingRow.game == game.name,
            RecordingRow.run_id.is_(None),
            RecordingRow.id.not_in(rankings.borrowed_ids(behaviour_id)),
            *rankings.RANKABLE,
            BehaviourRow.deleted_at.is_(None),
        )
    )
    return {
        key: (of, source, min(N_LENGTHS - 1, N_LENGTHS * n_frames // max_frames))
        for key, of, source, n_frames in session.execute(query.order_by(RecordingRow.id))
    }
