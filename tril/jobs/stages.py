"""The stages of a run, and how much of it they are."""

from __future__ import annotations

from tril.recipes import Recipe, recipe_from_dict
from tril.store.models import RunRow, RunStatus

STAGES = (
    "demonstrations",
    "trajectories",
    "reward",
    "check",
    "clone",
    "imitator",
    "evaluation",
    "attention",
)
"""In order. "demonstrations" is there in example runs only."""

DEMONSTRATIONS_S = 60.0
TRAJECTORIES_S = 6.0
CHECK_S = 4.0
ATTENTION_S = 8.0
N_DEMONSTRATIONS = 12
MEAN_STEPS = 250
"""Steps of a typical demonstration or evaluation game."""

REWARD_UPDATE_S = {"paper": 0.016, "fast": 0.4}
"""Seconds per update: 75 observations of one pair, or all observations of all demonstrations."""
CLONING_OBSERVATIONS_PER_S = {"nature": 1_600.0, "small": 4_200.0}
IMITATOR_STEPS_PER_S = {"nature": 250.0, "small": 480.0}
EVALUATION_STEPS_PER_S = 900.0
N_POLICIES_BY_CHOICES = 4


def stages_of(run: RunRow) -> tuple[str, ...]:
    """Return the stages that a run goes through, in order."""
    return STAGES if run.example else STAGES[1:]


def expected_seconds(recipe: Recipe, steps: int) -> dict[str, float]:
    """Return what each stage takes on two 2.5 GHz cores, by rates measured there.

    It is where an estimate begins before anything was measured on the machine at hand.
    """
    reward, network = recipe.reward, recipe.policy.network
    fits = reward.ensemble + reward.folds
    cloning_rate = CLONING_OBSERVATIONS_PER_S[recipe.cloning.network]
    n_starts = len(recipe.evaluation.start_numbers) + len(recipe.evaluation.further_start_numbers)
    games = n_starts * N_POLICIES_BY_CHOICES
    return {
        "demonstrations": DEMONSTRATIONS_S,
        "trajectories": TRAJECTORIES_S,
        "reward": reward.updates * REWARD_UPDATE_S[reward.method] * fits,
        "check": CHECK_S,
        "clone": recipe.cloning.epochs * N_DEMONSTRATIONS * MEAN_STEPS / cloning_rate,
        "imitator": steps / IMITATOR_STEPS_PER_S[network],
        "evaluation": 2.0 + games * MEAN_STEPS / EVALUATION_STEPS_PER_S,
        "attention": ATTENTION_S,
    }


def overall_progress(run: RunRow) -> float:
    """Return how much of a run is done, 0..1, weighting its stages by the time they take."""
    if run.status == RunStatus.DONE:
        return 1.0
    weights = expected_seconds(recipe_from_dict(run.recipe), run.steps)
    stages = stages_of(run)
    done = sum(weights[stage] for stage in stages if stage in run.finished_stages)
    if run.stage in stages and run.stage not in run.finished_stages:
        done += weights[run.stage] * run.stage_done
    return min(1.0, done / sum(weights[stage] for stage in stages))
