"""Varied games for a behaviour's ranking: borrowed from other behaviours, and random play.

A ranking of games of one kind shows few ways of being bad, and a reward learned from it
generalises badly. A borrowed game stays its own behaviour's recording; the borrowing behaviour's
ranking may hold it.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Hashable, Sequence

import numpy as np
from sqlalchemy import select
from sqlalchemy.orm import Session

from tril.errors import Conflict, NotFound
from tril.game.space_invaders import MAX_FRAMES
from tril.recording import Verified
from tril.store import behaviours, rankings, recordings
from tril.store.changes import note_change
from tril.store.database import Database
from tril.store.models import (
    BehaviourRow,
    BorrowedGameRow,
    RecordingRow,
    Source,
)

N_LENGTHS = 3
"""Classes of length that borrowed games are spread over, each an equal part of a whole game."""

Traits = tuple[Hashable, ...]


def listing(session: Session, behaviour_id: int) -> list[RecordingRow]:
    """Return the games that a behaviour has borrowed, the newest first, without deleted ones."""
    query = select(RecordingRow).where(
        RecordingRow.id.in_(rankings.borrowed_ids(behaviour_id)), RecordingRow.deleted_at.is_(None)
    )
    return list(session.scalars(query.order_by(RecordingRow.id.desc())))


def borrow(session: Session, behaviour_id: int, recording_ids: Sequence[int]) -> None:
    """Borrow games; those that can't be borrowed, or are already, are passed over."""
    rankings.lock(session, behaviour_id)
    possible = _borrowable(session, behaviour_id)
    for recording_id in recording_ids:
        if recording_id in possible:
            session.add(BorrowedGameRow(behaviour_id=behaviour_id, recording_id=recording_id))
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
    if row is None:
        raise NotFound(f"Recording {recording_id} is not borrowed by this behaviour.")
    if recording_id in rankings.as_ranking(newest).items:
        raise Conflict(
            f"Recording {recording_id} is ranked. Take it off the board before you give it back."
        )
    session.delete(row)
    note_change(session, "ranking", behaviour_id)


def add_varied_games(
    database: Database,
    behaviour_id: int,
    count: int,
    play: Callable[[int], Verified],
    rng: np.random.Generator,
) -> list[int]:
    """Add varied games to those that a behaviour's ranking may hold, in one transaction.

    At most half of them are borrowed, evenly over behaviours, sources and lengths; the others are
    random play, made now, and belong to the behaviour. No transaction is open while they are made.

    Args:
        database: The database.
        behaviour_id: Whose ranking may hold them.
        count: How many.
        play: Plays a game at random, from a seed.
        rng: Source of all random choices.

    Returns:
        The borrowed recordings, then those of random play.

    Raises:
        NotFound: No such behaviour.
    """
    with database.reading() as session:
        behaviours.get(session, behaviour_id)
        possible = _borrowable(session, behaviour_id)
    places = pick_evenly(list(possible.values()), count // 2, rng)
    chosen = [list(possible)[place] for place in places]
    games = [play(int(seed)) for seed in rng.integers(2**63, size=count - len(chosen))]
    with database.writing() as session:
        behaviours.get(session, behaviour_id)
        borrow(session, behaviour_id, chosen)
        made = [
            recordings.add(session, behaviour_id, game.recording, game.replay, Source.RANDOM).id
            for game in games
        ]
    return chosen + made


def pick_evenly(traits: Sequence[Traits], count: int, rng: np.random.Generator) -> list[int]:
    """Pick items so that each of their traits is spread evenly, and else at random.

    Args:
        traits: The traits of each item, as many of each.
        count: How many to pick, if there are as many.
        rng: Source of the choice among equals.

    Returns:
        Indices into ``traits``.
    """
    left = rng.permutation(len(traits)).tolist()
    n_picked: Counter[tuple[int, Hashable]] = Counter()
    picked = []
    for _ in range(min(count, len(traits))):
        best = min(left, key=lambda item: sum(n_picked[trait] for trait in enumerate(traits[item])))
        left.remove(best)
        n_picked.update(enumerate(traits[best]))
        picked.append(best)
    return picked


def _borrowable(session: Session, behaviour_id: int) -> dict[int, Traits]:
    """Return the behaviour, source and class of length of the games that could be borrowed."""
    query = (
        select(
            RecordingRow.id, RecordingRow.behaviour_id, RecordingRow.source, RecordingRow.n_frames
        )
        .join(BehaviourRow, BehaviourRow.id == RecordingRow.behaviour_id)
        .where(
            RecordingRow.behaviour_id != behaviour_id,
            RecordingRow.id.not_in(rankings.borrowed_ids(behaviour_id)),
            *rankings.RANKABLE,
            BehaviourRow.deleted_at.is_(None),
        )
    )
    return {
        key: (of, source, min(N_LENGTHS - 1, N_LENGTHS * n_frames // MAX_FRAMES))
        for key, of, source, n_frames in session.execute(query.order_by(RecordingRow.id))
    }
