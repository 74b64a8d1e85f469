"""How long a run takes, from what was measured on this machine where there is something."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from sqlalchemy.orm import Session

from tril.jobs.stages import expected_seconds
from tril.recipes import Recipe, recipe_from_dict
from tril.stages import Stage, stages_of
from tril.store.models import RunRow
from tril.store.training import runs

SLOWEST, FASTEST = 4.0, 0.25
"""Bounds of the correction that a run's own finished stages make to what is still to come."""


@dataclass(frozen=True)
class Estimate:
    """What a recipe costs on this machine.

    Attributes:
        steps_per_s: Steps of the imitator's training per second, judging its snapshots included.
        measured: Whether a finished run of the recipe was measured here; otherwise the rates of
            two 2.5 GHz cores are assumed.
        overhead_s: Seconds of everything that takes as long however many steps there are.
    """

    steps_per_s: float
    measured: bool
    overhead_s: float


def estimate(session: Session, recipe: Recipe) -> Estimate:
    """Return what a recipe costs here, by its newest finished run if there is one."""
    last = runs.latest_done(session, recipe.name)
    steps = recipe.default_steps
    seconds, at_once = (
        expected_seconds(recipe, n) if last is None else _measured(recipe, n, last)
        for n in (steps, 0)
    )
    # Before the first step and for judging the policy, a short training takes as long.
    training_s = seconds[Stage.IMITATOR] - at_once[Stage.IMITATOR]
    overhead_s = sum(s for stage, s in at_once.items() if stage is not Stage.DEMONSTRATIONS)
    return Estimate(steps / training_s, last is not None, overhead_s)


def _measured(recipe: Recipe, steps: int, last: RunRow) -> dict[Stage, float]:
    """Return expected seconds per stage, scaled by what another run's stages really took."""
    expected = expected_seconds(recipe, steps)
    of_last = expected_seconds(recipe_from_dict(last.recipe), last.steps)
    return {
        stage: seconds * last.finished_stages.get(stage, of_last[stage]) / of_last[stage]
        for stage, seconds in expected.items()
    }


@dataclass(frozen=True)
class RunEta:
    """What the stages of one run will take.

    Attributes:
        seconds: By stage, in order.
    """

    seconds: Mapping[str, float]

    @classmethod
    def of(cls, session: Session, run: RunRow) -> RunEta:
        """RunEta a run by the newest finished one of its recipe, or by typical rates."""
        recipe = recipe_from_dict(run.recipe)
        last = runs.latest_done(session, run.recipe_name)
        seconds = (
            expected_seconds(recipe, run.steps)
            if last is None
            else _measured(recipe, run.steps, last)
        )
        return cls({stage: seconds[stage] for stage in stages_of(run.example)})

    def remaining_s(
        self, finished: Mapping[str, float], stage: str, stage_remaining_s: float | None
    ) -> float:
        """Return the seconds that the rest of the run takes.

        Args:
            finished: Seconds that the finished stages took; they correct the forecast of those to
                come.
            stage: The stage at work.
            stage_remaining_s: Seconds that it will still take by its own measured rate; None when
                it has only begun.
        """
        foreseen = sum(self.seconds[name] for name in finished if name in self.seconds)
        took = sum(finished[name] for name in finished if name in self.seconds)
        pace = min(SLOWEST, max(FASTEST, took / foreseen)) if foreseen > 1.0 else 1.0
        later = sum(
            seconds
            for name, seconds in self.seconds.items()
            if name not in finished and name != stage
        )
        if stage_remaining_s is None:
            stage_remaining_s = 0.0 if stage in finished else pace * self.seconds.get(stage, 0.0)
        return stage_remaining_s + pace * later
