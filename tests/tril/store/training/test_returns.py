"""What the games of a run were worth, by who played them."""

from __future__ import annotations

import numpy as np

from testsupport.workplace import Workplace
from tril.analysis.outcome import CheckOutcome, RunOutcome
from tril.demonstrator import play_randomly
from tril.store import behaviours, borrowed, recordings
from tril.store.models import Source
from tril.store.training import runs
from tril.store.training.returns import PLAYERS, judged_games


def test_every_source_has_a_player() -> None:
    assert set(PLAYERS) == set(Source)


def test_borrowed_games_are_worth_what_they_are_to_the_run(workplace: Workplace) -> None:
    game = play_randomly(np.random.default_rng(0))
    run_id = workplace.make_run()
    with workplace.database.writing() as session:
        column_2 = behaviours.by_slug(session, "column-2").id
        lent = recordings.add(session, column_2, game.recording, game.replay, Source.VARIED)
        lent.hits = [[0, 0, 10], [1, 0, 20], [0, 1, 30]]
        borrowed.borrow(session, workplace.behaviour_id, [lent.id])
        run = runs.get(session, run_id)
        run.outcome = RunOutcome(check=_check({lent.id: 1.5}))
        (group,) = judged_games(session, run, [])
    assert (group.player, group.demonstrated) == ("varied", True)
    assert [(one.true_quantity, one.predicted_return) for one in group.games] == [(2 - 1, 1.5)]


def _check(predicted_returns: dict[int, float]) -> CheckOutcome:
    return CheckOutcome(
        tau=1.0,
        pair_accuracy=1.0,
        held_out_accuracy=None,
        passed=True,
        advice="",
        confused=[],
        predicted_returns=predicted_returns,
    )
