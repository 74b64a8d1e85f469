"""What the games of a run were worth, by who played them."""

from __future__ import annotations

import numpy as np
import pytest

from testsupport.workplace import Workplace
from tril.analysis.outcome import CheckOutcome, RunOutcome
from tril.demonstrators import play_randomly
from tril.games.behaviours import Score
from tril.games.space_invaders import SPACE_INVADERS
from tril.store import behaviours, borrowed, recordings
from tril.store.models import Source
from tril.store.training import evaluations, runs
from tril.store.training.evaluations import EvaluationKey
from tril.store.training.judged_games import PLAYERS, judged_games


def test_every_source_has_a_player() -> None:
    assert set(PLAYERS) == set(Source)


def test_borrowed_games_are_worth_what_they_are_to_the_run(workplace: Workplace) -> None:
    game = play_randomly(np.random.default_rng(0), SPACE_INVADERS.make_console())
    run_id = workplace.make_run()
    with workplace.database.writing() as session:
        column_2 = behaviours.by_slug(session, "column-2").id
        lent = recordings.add(session, column_2, game.recording, game.replay, Source.VARIED)
        lent.taken = [[0, 0, 10], [1, 0, 20], [0, 1, 30]]
        borrowed.borrow(session, workplace.behaviour_id, [lent.id])
        run = runs.get(session, run_id)
        run.outcome = RunOutcome(check=_check({lent.id: 1.5}))
        (group,) = judged_games(session, run, [])
    assert (group.player, group.demonstrated) == ("varied", True)
    assert [(one.true_quantity, one.predicted) for one in group.games] == [(2 - 1, 1.5)]


@pytest.mark.parametrize(
    ("kept", "measure", "shown", "unseen"),
    [
        (0.75, "final_level", [1.0, -0.5], [0.75]),
        (None, "predicted_return", [300.0, 200.0], [640.0]),
    ],
)
def test_games_are_judged_by_the_levels_they_end_at_if_all_are_known(
    workplace: Workplace, kept: float | None, measure: str, shown: list[float], unseen: list[float]
) -> None:
    run_id = workplace.make_run()
    best, worse, played, *_ = workplace.ranked
    with workplace.database.writing() as session:
        key = EvaluationKey("imitator", "greedy", 0)
        evaluations.add(session, run_id, key, played, True, 640.0, kept, Score(5, 0, 0))
        run = runs.get(session, run_id)
        levels = {best: 1.0, worse: -0.5}
        run.outcome = RunOutcome(check=_check({best: 300.0, worse: 200.0}, levels))
        groups = judged_games(session, run, evaluations.listing(session, run_id))
    assert [one.measure for one in groups] == [measure, measure]
    assert [[game.predicted for game in one.games] for one in groups] == [shown, unseen]


def _check(
    predicted_returns: dict[int, float], final_levels: dict[int, float] | None = None
) -> CheckOutcome:
    return CheckOutcome(
        tau=1.0,
        pair_accuracy=1.0,
        held_out_accuracy=None,
        passed=True,
        advice="",
        confused=[],
        predicted_returns=predicted_returns,
        final_levels=final_levels or {},
    )
