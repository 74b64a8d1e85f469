"""The games of a run that its report shows as clips."""

from __future__ import annotations

from collections.abc import Sequence

from tril.store.models import EvaluationRow
from tril.store.recordings import died


def best_and_worst(games: Sequence[EvaluationRow]) -> list[tuple[str, EvaluationRow]]:
    """Return the imitator's best and its worst evaluation game, with what they are.

    More targets are better, then fewer strays, then survival, then the predicted return; the first
    of equals counts. Only one is returned if they are the same.

    Args:
        games: A run's evaluation games, loaded with their recordings.
    """
    imitator_games = [game for game in games if game.policy == "imitator"]
    if not imitator_games:
        return []
    best, worst = max(imitator_games, key=_worth), min(imitator_games, key=_worth)
    if best is worst:
        return [("Its only game", best)]
    return [("Its best game", best), ("Its worst game", worst)]


def _worth(game: EvaluationRow) -> tuple[int, int, bool, float]:
    hits = len(game.recording.taken) if game.targets is None else game.targets
    survived = not died(game.recording)
    return hits, -(game.strays or 0), survived, game.predicted_return or 0.0
