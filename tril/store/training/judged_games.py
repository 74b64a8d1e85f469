"""What the reward of a run makes of its demonstrations and evaluation games."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from typing import cast, get_args

from sqlalchemy.orm import Session

from tril.analysis.extrapolation import (
    JudgedGame,
    JudgedGames,
    Measure,
    PlayerKind,
    true_quantity,
)
from tril.analysis.outcome import CheckOutcome
from tril.games.behaviours import score
from tril.store import behaviours, recordings
from tril.store.models import EvaluationRow, RunRow, Source
from tril.store.recordings import cells_of

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
    """Return all games that R has judged, the demonstrations first.

    They are judged by their final levels; those of a run of an earlier version, which did not keep
    them, by their predicted returns.

    Args:
        session: The transaction.
        run: The run.
        games: Evaluation games of the run, loaded with their recordings.

    Returns:
        By player; empty for behaviours without target cells, whose games have no true quantity.
    """
    behaviour = behaviours.as_behaviour(behaviours.get(session, run.behaviour_id))
    if behaviour.target is None:
        return []
    measure, predicted = _measure_of(run.outcome.check, games)
    games_by_player: dict[tuple[PlayerKind, bool], list[JudgedGame]] = defaultdict(list)
    for number, row in recordings.by_ids(session, list(predicted)).items():
        worth = score(behaviour, cells_of(row))
        assert worth is not None
        quantity = true_quantity(worth.targets, worth.strays)
        game = JudgedGame(quantity, predicted[number], number)
        games_by_player[PLAYERS[row.source], True].append(game)
    for played in games:
        value = played.final_level if measure == "final_level" else played.predicted_return
        if value is None or played.targets is None or played.strays is None:
            continue
        quantity = true_quantity(played.targets, played.strays)
        game = JudgedGame(quantity, value, played.recording_id)
        games_by_player[cast(PlayerKind, played.policy), False].append(game)
    return [
        JudgedGames(player, demonstrated, measure, tuple(games_by_player[player, demonstrated]))
        for player, demonstrated in sorted(games_by_player, key=_place)
    ]


def _measure_of(
    check: CheckOutcome | None, games: Sequence[EvaluationRow]
) -> tuple[Measure, dict[int, float]]:
    """Return the measure that can judge all games, and its values for demonstrations, by id."""
    if check is None:
        return "predicted_return", {}
    if check.final_levels and all(game.final_level is not None for game in games):
        return "final_level", check.final_levels
    return "predicted_return", check.predicted_returns


def _place(group: tuple[PlayerKind, bool]) -> tuple[bool, int]:
    """Return the key that sorts demonstrations first, then by player."""
    player, demonstrated = group
    return not demonstrated, get_args(PlayerKind).index(player)
