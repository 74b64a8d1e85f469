"""The predicted returns of a run's demonstrations and evaluation games."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from typing import cast, get_args

from sqlalchemy.orm import Session

from tril.analysis.extrapolation import JudgedGame, JudgedGames, PlayerKind, true_quantity
from tril.behaviours import score
from tril.store import behaviours, recordings
from tril.store.models import EvaluationRow, RunRow, Source

PLAYERS: dict[str, PlayerKind] = {
    Source.PERSON: "person",
    Source.SCRIPTED: "demonstrator",
    Source.POLICY: "imitator",
    Source.VARIED: "varied",
}
"""Who is said to have played the recordings of each source."""


def judged_games(
    session: Session, run: RunRow, games: Sequence[EvaluationRow]
) -> list[JudgedGames]:
    """Return all games whose predicted return is known, the demonstrations first.

    Args:
        session: The transaction.
        run: The run.
        games: Its evaluation games, loaded with their recordings.

    Returns:
        By player; empty for behaviours without target cells, whose games have no true quantity.
    """
    behaviour = behaviours.as_behaviour(behaviours.get(session, run.behaviour_id))
    if behaviour.target is None:
        return []
    check = run.outcome.check
    returns = {} if check is None else check.predicted_returns
    found: dict[tuple[PlayerKind, bool], list[JudgedGame]] = defaultdict(list)
    for number, row in recordings.by_ids(session, list(returns)).items():
        worth = score(behaviour, tuple((r, c) for r, c, _ in row.hits))
        assert worth is not None
        quantity = true_quantity(worth.targets, worth.strays)
        game = JudgedGame(quantity, returns[number], number)
        found[PLAYERS[row.source], True].append(game)
    for played in games:
        if played.predicted_return is None or played.targets is None or played.strays is None:
            continue
        quantity = true_quantity(played.targets, played.strays)
        game = JudgedGame(quantity, played.predicted_return, played.recording_id)
        found[cast(PlayerKind, played.policy), False].append(game)
    return [
        JudgedGames(player, demonstrated, tuple(found[player, demonstrated]))
        for player, demonstrated in sorted(found, key=_place)
    ]


def _place(group: tuple[PlayerKind, bool]) -> tuple[bool, int]:
    """Return the key that sorts demonstrations first, then by player."""
    player, demonstrated = group
    return not demonstrated, get_args(PlayerKind).index(player)
