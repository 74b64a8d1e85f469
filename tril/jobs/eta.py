"""How much of a run is done and how long it will take.

Estimates are scaled by the newest finished run of the same recipe, if there is one.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from sqlalchemy.orm import Session

from tril.errors import Invalid
from tril.jobs.durations import expected_seconds
from tril.recipes import Recipe, recipe_from_dict
from tril.stages import Stage, stages_of
from tril.store.models import RunRow, RunStatus
from tril.store.training import runs

SLOWEST, FASTEST = 4.0, 0.25
"""Bounds of the correction by which a run's finished stages scale those still to come."""


NEGLIGIBLE_S = 20.0
"""What a stage takes besides what grows with its work; a stage that took little more says little of
how fast the machine is."""


@dataclass(frozen=True)
class CostEstimate:
    """What a recipe costs on this machine.

    Attributes:
        steps_per_s: Steps of the imitator's training per second, judging its snapshots included.
        measured: Whether a finished run of the recipe was measured here; otherwise the rates of
            two 2.5 GHz cores are assumed.
        overhead_s: Seconds that do not depend on the number of steps.
    """

    steps_per_s: float
    measured: bool
    overhead_s: float


def estimate(session: Session, recipe: Recipe) -> CostEstimate:
    """Estimate what a recipe costs here."""
    last = runs.latest_done(session, recipe.name)
    steps = recipe.default_steps
    seconds, fixed = (_stage_seconds(recipe, n, last) for n in (steps, 0))
    training_s = seconds[Stage.IMITATOR] - fixed[Stage.IMITATOR]
    overhead_s = sum(s for stage, s in fixed.items() if stage is not Stage.DEMONSTRATIONS)
    return CostEstimate(steps / training_s, last is not None, overhead_s)


def _stage_seconds(recipe: Recipe, steps: int, last: RunRow | None) -> dict[Stage, float]:
    """Return the seconds expected for each stage, scaled by what a finished run's stages took."""
    expected = expected_seconds(recipe, steps)
    if last is None:
        return expected
    of_last = expected_seconds(recipe_from_dict(last.recipe), last.steps)
    return {
        stage: seconds * _slowness(last.finished_stages.get(stage, of_last[stage]), of_last[stage])
        for stage, seconds in expected.items()
    }


def _slowness(took_s: float, expected_s: float) -> float:
    """Return how much longer a stage took than expected, about 1 if it was a short one."""
    return (took_s + NEGLIGIBLE_S) / (expected_s + NEGLIGIBLE_S)


@dataclass(frozen=True)
class RunEta:
    """What the stages of one run are expected to take.

    Attributes:
        seconds: By stage, in order.
    """

    seconds: Mapping[str, float]

    @classmethod
    def of(cls, session: Session, run: RunRow) -> RunEta:
        """Estimate the stages of a run."""
        recipe = recipe_from_dict(run.recipe)
        seconds = _stage_seconds(recipe, run.steps, runs.latest_done(session, run.recipe_name))
        return cls({stage: seconds[stage] for stage in stages_of(run.example)})

    def remaining_s(
        self, finished: Mapping[str, float], stage: str, stage_remaining_s: float | None
    ) -> float:
        """Return the estimated seconds to the end of the run.

        Args:
            finished: Seconds that the finished stages took; they scale those still to come.
            stage: The stage at work.
            stage_remaining_s: Seconds that it still takes by its own rate; None if too little of
                it is done to tell.
        """
        known = [name for name in finished if name in self.seconds]
        expected = sum(self.seconds[name] for name in known)
        took = sum(finished[name] for name in known)
        pace = min(SLOWEST, max(FASTEST, took / expected)) if expected > 1.0 else 1.0
        later = sum(
            seconds
            for name, seconds in self.seconds.items()
            if name not in finished and name != stage
        )
        if stage_remaining_s is None:
            stage_remaining_s = 0.0 if stage in finished else pace * self.seconds.get(stage, 0.0)
        return stage_remaining_s + pace * later


def overall_progress(run: RunRow) -> float:
    """Return how much of a run is done, 0..1, weighting its stages by the time they take."""
    if run.status == RunStatus.DONE:
        return 1.0
    stages = stages_of(run.example)
    try:
        weights = expected_seconds(recipe_from_dict(run.recipe), run.steps)
    except Invalid:
        # A recipe of another version: the run is listed all the same.
        weights = dict.fromkeys(stages, 1.0)
    done = sum(weights[stage] for stage in stages if stage in run.finished_stages)
    if run.stage in stages and run.stage not in run.finished_stages:
        done += weights[Stage(run.stage)] * run.stage_done
    return min(1.0, done / sum(weights[stage] for stage in stages))
