"""Export and import of a run's blind comparisons, with everything that people did in them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from sqlalchemy.orm import Session

from tril.analysis.blind import BlindAnswer
from tril.exchange.formats.run_file import BlindAnswerObject, RunObject
from tril.store import players
from tril.store.models import BlindAnswerRow
from tril.store.training import blind_answers


def blind_objects(session: Session, run_id: str) -> dict[str, Any]:
    """Return the member of a run's file that holds them, if there are any.

    Without any there is no such member, which earlier versions would refuse.
    """
    names = players.names(session)
    answers = [
        BlindAnswerObject(
            player=None if row.player_id is None else names.get(row.player_id),
            round=row.round,
            pair=row.pair,
            imitator=row.imitator_id,
            other=row.other_id,
            imitator_left=row.imitator_left,
            answer=BlindAnswer(row.answer),
            answered_at=row.created_at,
        )
        for row in blind_answers.rows_of(session, run_id)
    ]
    return {"blind": answers} if answers else {}


def add_blind_answers(session: Session, run: RunObject, ids: Mapping[int, int]) -> None:
    """Add an imported run's blind comparisons.

    Args:
        session: The transaction, in which the run and its games are there.
        run: The run's file.
        ids: Recordings by their number in the file.
    """
    named = {
        name: players.named(session, name).id
        for name in dict.fromkeys(one.player for one in run.blind)
        if name is not None
    }
    session.add_all(
        BlindAnswerRow(
            run_id=run.id,
            player_id=None if one.player is None else named[one.player],
            round=one.round,
            pair=one.pair,
            imitator_id=ids[one.imitator],
            other_id=ids[one.other],
            imitator_left=one.imitator_left,
            answer=one.answer,
            created_at=one.answered_at,
        )
        for one in run.blind
    )
