"""A library in brief, in columns: one list for each field."""

from __future__ import annotations

from sqlalchemy.orm import Session

from server.api.schemas.library import Library, LibraryColumns
from tril.games import game_of
from tril.games.behaviours import score
from tril.store import behaviours, library, rankings
from tril.store.access.credentials import Identity
from tril.store.models import BehaviourRow


def library_view(
    session: Session,
    who: Identity,
    behaviour: BehaviourRow,
    brief: library.Brief,
    *,
    borrowed: bool = False,
) -> Library:
    """Show a library, or what of it changed, by a behaviour's target.

    Args:
        session: The transaction.
        who: Who reads it. A participant is told nothing of marks, ranking and parents.
        behaviour: The behaviour that it is shown for.
        brief: The library.
        borrowed: Whether it is what the behaviour has borrowed, which is never perfect there.
    """
    target = behaviours.as_behaviour(behaviour)
    game = game_of(target)
    entries = brief.entries
    knows_all = not who.is_participant
    cells = [tuple((row, column) for row, column, _ in entry.taken) for entry in entries]
    scores = [score(target, hits) for hits in cells]
    ranking = rankings.as_ranking(rankings.current(session, behaviour.id))
    return Library(
        cursor=brief.cursor,
        whole=brief.whole,
        removed=list(brief.removed),
        ranked=list(ranking.items) if knows_all else [],
        recordings=LibraryColumns(
            id=[entry.id for entry in entries],
            source=[entry.source for entry in entries],
            player=[entry.player for entry in entries],
            run_id=[entry.run_id if knows_all else None for entry in entries],
            parent_id=[entry.parent_id if knows_all else None for entry in entries],
            parent_frame=[entry.parent_frame if knows_all else None for entry in entries],
            state=[entry.state for entry in entries],
            verification=[entry.verification for entry in entries],
            n_frames=[entry.n_frames for entry in entries],
            n_steps=[game.clock.n_steps(entry.n_frames) for entry in entries],
            end=[entry.end for entry in entries],
            n_hits=[len(hits) for hits in cells],
            targets=[None if one is None else one.targets for one in scores],
            strays=[None if one is None else one.strays for one in scores],
            order_errors=[None if one is None else one.order_errors for one in scores],
            counters={
                name: [entry.counters.get(name, 0) for entry in entries] for name in game.counters
            },
            score=[entry.score for entry in entries],
            measured=[
                [entry.measured.get(measure.key) for entry in entries]
                for measure in target.measures
            ],
            perfect=[knows_all and not borrowed and entry.perfect for entry in entries],
            deleted=[entry.deleted_at is not None for entry in entries],
        ),
    )
