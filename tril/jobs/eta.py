"""How much of a run is done and how long it will take.

Estimates are scaled by the newest finished run of the same recipe, if there is one.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass

from sqlalchemy.orm import Session

from tril.errors import Invalid
from tril.jobs.durations import expected_seconds
from tril.recipes import Recipe, recipe_from_dict
from tril.stages import Stage, stages_of
from tril.store.models import RunRow, RunStatus
from tril.store.training import runs

SLOWEST, FASTEST = 4.0, 0.25
"""Bounds of the correction by which what a run has done scales the stages still to come."""

NEGLIGIBLE_S = 20.0
"""What a stage takes besides what grows with its work; a stage that took little more says little of
how fast the machine is."""

PRIOR_SHARE = 0.25
"""What a run has done says as much of the stages to come as their estimate when it is this share of
the whole: a short stage says little of a long one."""

SMOOTHED_S = 90.0
"""Time constant of the mean of estimates that people are told."""


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


def _slowness(
    took_s: float, expected_s: float, prior: float = 1.0, prior_s: float = NEGLIGIBLE_S
) -> float:
    """Return the ratio of actual to expected time, about ``prior`` if it was short.

    Args:
        took_s: Seconds that it took.
        expected_s: Seconds that were expected.
        prior: The answer where nothing is known.
        prior_s: Expected seconds of which that is as sure as what was measured.
    """
    return (took_s + prior_s * prior) / (expected_s + prior_s)


@dataclass(frozen=True)
class RunEta:
    """What the stages of one run are expected to take: how much is done and what remains.

    Attributes:
        seconds: Expected seconds by stage, in order.
    """

    seconds: Mapping[str, float]

    @classmethod
    def of(cls, session: Session, run: RunRow) -> RunEta:
        """Estimate the stages of a run, always in the same way once it has begun.

        Raises:
            Invalid: A recipe is one of another version.
        """
        recipe = recipe_from_dict(run.recipe)
        last = runs.latest_done(session, run.recipe_name, before=run.started_at)
        seconds = _stage_seconds(recipe, run.steps, last)
        return cls({stage: seconds[stage] for stage in stages_of(run.example)})

    def progress(self, finished: Collection[str], stage: str, done: float) -> float:
        """Return the finished share of the run, 0..1, weighting its stages by their duration.

        Args:
            finished: The finished stages.
            stage: The stage at work.
            done: Share of it that is done, 0..1.
        """
        remaining = sum(self._left(finished, stage, done).values())
        return 1.0 - remaining / sum(self.seconds.values())

    def remaining_s(
        self,
        finished: Mapping[str, float],
        stage: str,
        done: float,
        gained: float = 0.0,
        took_s: float = 0.0,
    ) -> float:
        """Return the estimated seconds to the end of the run, of what ``progress`` says is left.

        What was done scales it, the stage at work by its own speed.

        Args:
            finished: Seconds that the finished stages took.
            stage: The stage at work.
            done: Share of it that is done, 0..1.
            gained: Share of it whose duration is known; 0 if too little of it is done to tell.
            took_s: Seconds that this share took.
        """
        known_stages = [name for name in finished if name in self.seconds]
        expected = sum(self.seconds[name] for name in known_stages)
        took = sum(finished[name] for name in known_stages)
        gained_s = gained * self.seconds.get(stage, 0.0)
        prior_s = max(NEGLIGIBLE_S, PRIOR_SHARE * sum(self.seconds.values()))
        before = _bounded(_slowness(took, expected, prior_s=prior_s))
        stage_slowness = _slowness(took_s, gained_s, prior=before)
        pace = _bounded(_slowness(took + took_s, expected + gained_s, prior_s=prior_s))
        remaining = self._left(finished, stage, done)
        return stage_slowness * remaining.pop(stage, 0.0) + pace * sum(remaining.values())

    def _left(self, finished: Collection[str], stage: str, done: float) -> dict[str, float]:
        """Return the seconds expected of what is left of each stage that is not finished."""
        return {
            name: seconds * (1.0 - done if name == stage else 1.0)
            for name, seconds in self.seconds.items()
            if name not in finished
        }


def coarse_step_s(remaining_s: float) -> float:
    """Return the seconds to which a remaining time is told: a minute, five, or a quarter hour."""
    if remaining_s < 600.0:
        return 60.0
    return 300.0 if remaining_s < 3600.0 else 900.0


@dataclass
class SteadyRemaining:
    """Remaining time that counts down, and is corrected by no less than a coarse step.

    Estimates jump where a stage begins or is slower for a while. Their mean over the last minutes
    says when the run ends; what is told follows it once it is a coarse step off.
    """

    _mean_end: float | None = None
    _told_end: float = 0.0
    _at: float = 0.0

    def update(self, at: float, estimate_s: float) -> float:
        """Take an estimate in, and return what is told.

        Args:
            at: Seconds of a monotonic clock.
            estimate_s: Estimated seconds to the end of the run.
        """
        end = at + estimate_s
        if self._mean_end is None:
            self._mean_end = self._told_end = end
        weight = 1.0 - math.exp((self._at - at) / SMOOTHED_S)
        self._mean_end += weight * (end - self._mean_end)
        self._at = at
        if abs(self._mean_end - self._told_end) >= coarse_step_s(self._told_end - at):
            self._told_end = self._mean_end
        return max(0.0, self._told_end - at)


def _bounded(slowness: float) -> float:
    return min(SLOWEST, max(FASTEST, slowness))


def overall_progress(session: Session, run: RunRow) -> float:
    """Return the finished share of a run, 0..1, by the estimate of its remaining time."""
    if run.status == RunStatus.DONE:
        return 1.0
    if not run.finished_stages and not run.stage_done:
        return 0.0
    try:
        eta = RunEta.of(session, run)
    except Invalid:
        # A recipe of another version: the run is listed all the same.
        eta = RunEta(dict.fromkeys(stages_of(run.example), 1.0))
    return eta.progress(run.finished_stages, run.stage, run.stage_done)
