"""Which games a run's report shows as clips."""

from __future__ import annotations

from trainer.archive.games import best_and_worst
from tril.store.models import EvaluationRow, RecordingRow


def game(
    policy: str, targets: int | None, strays: int | None = 0, end: str = "steps", hits: int = 0
) -> EvaluationRow:
    row = EvaluationRow(policy=policy, targets=targets, strays=strays, predicted_return=1.0)
    row.recording = RecordingRow(game="space_invaders", end=end, taken=[[0, 0, 1]] * hits)
    return row


def test_the_imitators_best_and_worst_game_are_shown() -> None:
    best, worst = game("imitator", 6), game("imitator", 2, end="hit")
    games = [
        game("clone", 0),
        game("imitator", 6, strays=1),
        game("imitator", 6, end="hit"),
        best,
        game("imitator", 2),
        worst,
    ]
    assert [one for _, one in best_and_worst(games)] == [best, worst]


def test_without_targets_the_hits_count() -> None:
    best, worst = game("imitator", None, None, hits=9), game("imitator", None, None, hits=1)
    assert [one for _, one in best_and_worst([worst, best])] == [best, worst]


def test_one_game_is_shown_once_and_none_not_at_all() -> None:
    only = game("imitator", 3)
    assert best_and_worst([only, game("clone", 6)]) == [("Its only game", only)]
    assert best_and_worst([game("clone", 6)]) == []
