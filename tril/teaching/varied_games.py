"""Games of many kinds for a ranking: borrowed from other behaviours, and varied play.

A ranking of games of one kind shows few ways of being bad, and a reward learned from it generalises
badly.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from tril.analysis.variety import pick_evenly
from tril.recording import Verified
from tril.store import behaviours, borrowed, recordings
from tril.store.database import Database
from tril.store.models import Source


def add_varied_games(
    database: Database,
    behaviour_id: int,
    count: int,
    play: Callable[[int], Verified],
    rng: np.random.Generator,
) -> list[int]:
    """Add varied games to those that a behaviour's ranking may hold, in one transaction.

    At most half of them are borrowed, evenly over behaviours, sources and lengths; the others are
    varied play, made now, and belong to the behaviour. No transaction is open while they are made.

    Args:
        database: The database.
        behaviour_id: Behaviour of the ranking.
        count: Number of games.
        play: Plays a game of varied play, from a seed.
        rng: Source of all random choices.

    Returns:
        The borrowed recordings, then those of varied play.

    Raises:
        NotFound: No such behaviour.
    """
    with database.reading() as session:
        behaviours.get(session, behaviour_id)
        possible = borrowed.borrowable(session, behaviour_id)
    places = pick_evenly(list(possible.values()), count // 2, rng)
    chosen = [list(possible)[place] for place in places]
    games = [play(int(seed)) for seed in rng.integers(2**63, size=count - len(chosen))]
    with database.writing() as session:
        behaviours.get(session, behaviour_id)
        # Some may have been deleted, or borrowed, meanwhile.
        borrowed.borrow(
            session, behaviour_id, borrowed.borrowable(session, behaviour_id).keys() & chosen
        )
        recording_ids = [
            recordings.add(session, behaviour_id, game.recording, game.replay, Source.VARIED).id
            for game in games
        ]
    return chosen + recording_ids
