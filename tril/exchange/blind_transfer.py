"""Export and import of a run's blind comparisons, with everything that people did in them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from sqlalchemy.orm import Session

from tril.analysis.blind import BlindAnswer
from tril.exchange.formats.run_file import MAX_BLIND_ANSWERS, BlindAnswerObject, RunObject
from tril.store import players
from tril.store.models import BlindAnswerRow
from tril.store.training import blind_answers
from tril.text import folded


def blind_objects(session: Session, run_id: str) -> dict[str, Any]:
    """Return the member of a run's file that holds them, if there are any.

    Without any there is no such member, which earlier versions would refuse. People of the same
    name are numbered, so that they stay apart. Where there are too many answers for a file, those
    of the earliest rounds are left out, and what was taken back.
    """
    names = _distinct(players.names(session))
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
        for row in _most(blind_answers.rows_of(session, run_id), MAX_BLIND_ANSWERS)
    ]
    return {"blind": answers} if answers else {}


def _distinct(names: Mapping[int, str]) -> dict[int, str]:
    """Return people's names by id, those that others have, too, with a number behind them."""
    taken: set[str] = set()
    distinct: dict[int, str] = {}
    for player_id, name in sorted(names.items()):
        number, own = 1, name
        while folded(own) in taken:
            number += 1
            own = f"{name} ({number})"
        taken.add(folded(own))
        distinct[player_id] = own
    return distinct


def _most(rows: Sequence[BlindAnswerRow], most: int) -> list[BlindAnswerRow]:
    """Return rows, at most so many, from which the same result follows.

    Args:
        rows: All answers of a run, oldest first.
        most: How many are kept at most.
    """
    if len(rows) <= most:
        return list(rows)
    rounds: dict[tuple[int | None, int], dict[int, BlindAnswerRow]] = {}
    ended: dict[tuple[int | None, int], BlindAnswerRow] = {}
    for row in rows:
        key = row.player_id, row.round
        if row.answer == BlindAnswer.ENDED:
            ended[key] = row
        elif row.answer == BlindAnswer.TAKEN_BACK:
            rounds.setdefault(key, {}).pop(row.pair, None)
        else:
            rounds.setdefault(key, {})[row.pair] = row
    # The latest finished round of each person, which counts, then what is newest.
    counting = {
        player: max(number for one, number in ended if one == player) for player, _ in ended
    }
    kept: list[BlindAnswerRow] = []
    for key in sorted(rounds, key=lambda key: (counting.get(key[0]) != key[1], -key[1])):
        of_round = [*rounds[key].values(), *([ended[key]] if key in ended else [])]
        if len(kept) + len(of_round) > most:
            break
        kept += of_round
    return sorted(kept, key=lambda row: row.id)


def add_blind_answers(session: Session, run: RunObject, ids: Mapping[int, int]) -> None:
    """Add an imported run's blind comparisons, of people who have not signed in here.

    Nobody else counts, nor does the owner: somebody of the same name may have made them, and whose
    own they are, is shown whose games were whose.

    Args:
        session: The transaction, in which the run and its games are there.
        run: The run's file.
        ids: Recordings by their number in the file.
    """
    named = {
        name: players.named(session, name, owner_counts=False).id
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
