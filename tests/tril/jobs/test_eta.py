"""Progress over a whole run and what remains of it."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from testsupport.workplace import Workplace
from tril.jobs import CostEstimate, RunEta, estimate, overall_progress
from tril.jobs.durations import expected_seconds
from tril.jobs.eta import NEGLIGIBLE_S, PRIOR_SHARE, SteadyRemaining
from tril.recipes import FAST, RECIPES, Recipe
from tril.stages import Stage, stages_of
from tril.store.models import RunRow, RunStatus
from tril.store.training import leases, runs


def run_at(stage: str, done: float, recipe: Recipe = FAST) -> RunRow:
    finished = itertools.takewhile(lambda one: one != stage, stages_of(example=False))
    return RunRow(
        recipe=recipe.to_dict(),
        steps=300_000,
        example=False,
        status=RunStatus.RUNNING,
        stage=stage,
        stage_done=done,
        finished_stages=dict.fromkeys(finished, 1.0),
    )


@pytest.mark.parametrize("recipe", RECIPES.values(), ids=RECIPES)
def test_progress_rises_through_all_stages_from_none_to_all(
    workplace: Workplace, recipe: Recipe
) -> None:
    with workplace.database.reading() as session:
        values = [
            overall_progress(session, run_at(stage, done, recipe))
            for stage in stages_of(example=False)
            for done in (0.0, 0.5, 1.0)
        ]
    assert values == sorted(values)
    assert values[0] == 0.0
    assert values[-1] == pytest.approx(1.0)


def test_the_demonstrations_are_a_stage_of_examples_only() -> None:
    assert stages_of(example=True) == tuple(Stage)
    assert stages_of(example=False) == tuple(Stage)[1:]


def test_only_the_imitator_takes_longer_with_more_steps() -> None:
    few, more, most = (expected_seconds(FAST, steps) for steps in (0, 100_000, 1_000_000))
    assert most[Stage.IMITATOR] - few[Stage.IMITATOR] == pytest.approx(
        10 * (more[Stage.IMITATOR] - few[Stage.IMITATOR])
    )
    del few[Stage.IMITATOR], most[Stage.IMITATOR]
    assert few == most


def test_a_run_of_an_unknown_recipe_still_has_a_progress(workplace: Workplace) -> None:
    run = run_at("clone", 0.5)
    run.recipe = {"name": "of another version"}
    with workplace.database.reading() as session:
        assert overall_progress(session, run) == pytest.approx(3.5 / 7)


ETA = RunEta({"reward": 10.0, "imitator": 100.0, "evaluation": 20.0})


def test_what_remains_follows_the_pace_of_what_is_done() -> None:
    assert ETA.remaining_s({}, "reward", 0.0) == pytest.approx(130.0)
    # A short stage that took four times as long says little of the others.
    after_reward = ETA.remaining_s({"reward": 40.0}, "imitator", 0.0)
    slower = (40.0 + PRIOR_SHARE * 130.0) / (10.0 + PRIOR_SHARE * 130.0)
    assert after_reward == pytest.approx(120.0 * slower)
    assert slower < 2.0
    # The stage at work goes on at its own speed, after a while whatever came before.
    halfway = ETA.remaining_s({"reward": 40.0}, "imitator", 0.5, 0.5, 100.0)
    own = (100.0 + NEGLIGIBLE_S * slower) / (50.0 + NEGLIGIBLE_S)
    pace = (140.0 + PRIOR_SHARE * 130.0) / (60.0 + PRIOR_SHARE * 130.0)
    assert halfway == pytest.approx(50.0 * own + 20.0 * pace)


def test_what_remains_at_a_steady_pace_is_what_progress_leaves() -> None:
    for place in range(11):
        done = place / 10
        left = 1.0 - ETA.progress({"reward"}, "imitator", done)
        remaining_s = ETA.remaining_s({"reward": 10.0}, "imitator", done, done, 100.0 * done)
        assert remaining_s == pytest.approx(130.0 * left)


def test_a_told_remaining_time_counts_down_and_is_corrected_by_coarse_steps_only() -> None:
    steady, told = SteadyRemaining(), []
    rng = np.random.default_rng(3)
    for second in range(1200):
        # A run of 30 minutes whose estimates swing by a quarter, and one stage that is slower.
        left_s = 1800.0 - second + (600.0 if 400 <= second < 430 else 0.0)
        told.append(steady.update(float(second), left_s * rng.uniform(0.75, 1.25)))
    rises = [after - before for before, after in itertools.pairwise(told) if after > before]
    assert all(rise >= 60.0 - 1.0 for rise in rises)
    assert len(rises) <= 3
    assert abs(told[-1] - 600.0) < 2 * 60.0 + 60.0


def test_a_told_remaining_time_follows_a_run_that_turns_out_to_be_slower() -> None:
    steady = SteadyRemaining()
    assert steady.update(0.0, 300.0) == pytest.approx(300.0)
    for second in range(1, 600):
        told = steady.update(float(second), 1800.0 - second)
    assert told == pytest.approx(1200.0, abs=300.0)


def finish_run(
    workplace: Workplace, recipe: Recipe, steps: int, slowness: float, own_s: float
) -> None:
    """Finish a run whose stages took longer than expected, by a factor and by some seconds."""
    lease = workplace.lease(workplace.make_run(recipe, steps))
    with workplace.database.writing() as session:
        for stage, seconds in expected_seconds(recipe, steps).items():
            leases.finish_stage(session, lease, stage, slowness * seconds + own_s)
        leases.end(session, lease, RunStatus.DONE)


def estimated(workplace: Workplace, recipe: Recipe) -> CostEstimate:
    with workplace.database.reading() as session:
        return estimate(session, recipe)


def test_an_estimate_is_measured_once_a_run_of_the_recipe_is_done(workplace: Workplace) -> None:
    guessed = estimated(workplace, FAST)
    assert not guessed.measured
    finish_run(workplace, FAST, 1_000_000, slowness=2.0, own_s=NEGLIGIBLE_S)
    measured = estimated(workplace, FAST)
    assert measured.measured
    assert measured.steps_per_s == pytest.approx(guessed.steps_per_s / 2, rel=0.05)
    assert guessed.overhead_s * 1.5 < measured.overhead_s < guessed.overhead_s * 2.5


def test_the_estimate_of_a_run_stays_when_another_is_done_meanwhile(workplace: Workplace) -> None:
    run_id = workplace.make_run(FAST)
    workplace.lease(run_id)

    def seconds() -> dict[str, float]:
        with workplace.database.reading() as session:
            return dict(RunEta.of(session, runs.get(session, run_id)).seconds)

    before = seconds()
    finish_run(workplace, FAST, 1_000_000, slowness=2.0, own_s=0.0)
    assert seconds() == before


def test_a_short_run_says_little_of_how_long_a_long_one_takes(workplace: Workplace) -> None:
    guessed = estimated(workplace, FAST)
    # What setting up takes is not mistaken for training.
    finish_run(workplace, FAST, 1_000, slowness=1.0, own_s=25.0)
    measured = estimated(workplace, FAST)
    assert measured.steps_per_s > guessed.steps_per_s / 2.5
