"""The stages of a run, and how much of it they are."""

from __future__ import annotations

from tril.errors import Invalid
from tril.recipes import Recipe, RewardRecipe, recipe_from_dict
from tril.store.models import RunRow, RunStatus
from tril.store.training.evaluations import ACTION_SELECTIONS, POLICIES

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

DEMONSTRATIONS_S = 30.0
TRAJECTORIES_S = 6.0
CHECK_S = 4.0
ATTENTION_S = 8.0
N_DEMONSTRATIONS = 12
MEAN_STEPS = 250
"""Steps of a typical demonstration or evaluation game."""

REWARD_OBSERVATIONS_PER_S = 4_500.0
REWARD_UPDATE_S = 0.003
"""What an update of the reward model costs beside its observations."""
CLONING_OBSERVATIONS_PER_S = {"nature": 1_600.0, "small": 4_200.0}
IMITATOR_STEPS_PER_S = {"nature": 400.0, "small": 750.0}
DAGGER_LABELS_PER_S = 100.0
DAGGER_EPOCHS_SHARE = 0.4
"""Of the passes that early stopping leaves."""
EVALUATION_STEPS_PER_S = 900.0


def stages_of(run: RunRow) -> tuple[str, ...]:
    """Return the stages that a run goes through, in order."""
    return STAGES if run.example else STAGES[1:]


def expected_seconds(recipe: Recipe, steps: int) -> dict[str, float]:
    """Return what each stage takes on two 2.5 GHz cores, by rates measured there.

    It is where an estimate begins before anything was measured on the machine at hand.
    """
    reward = recipe.reward
    cloning_rate = CLONING_OBSERVATIONS_PER_S[recipe.cloning.network]
    n_starts = len(recipe.evaluation.start_numbers) + len(recipe.evaluation.further_start_numbers)
    games = n_starts * len(POLICIES) * len(ACTION_SELECTIONS)
    demonstrated = N_DEMONSTRATIONS * MEAN_STEPS
    return {
        "demonstrations": DEMONSTRATIONS_S,
        "trajectories": TRAJECTORIES_S,
        "reward": 1.0 + reward.ensemble * _learning_seconds(reward),
        "check": CHECK_S + reward.folds * _learning_seconds(reward.of_fold),
        "clone": 1.0 + recipe.cloning.epochs * demonstrated / cloning_rate,
        "imitator": 2.0 + _imitator_seconds(recipe, steps),
        "evaluation": 4.0 + games * MEAN_STEPS / EVALUATION_STEPS_PER_S,
        "attention": ATTENTION_S,
    }


def _imitator_seconds(recipe: Recipe, steps: int) -> float:
    """Return what the imitator's training takes."""
    judging_s = recipe.policy.snapshot_episodes * MEAN_STEPS / EVALUATION_STEPS_PER_S
    if recipe.method != "dagger":
        snapshots = 1 + sum(due <= steps for due in recipe.policy.snapshot_steps)
        return snapshots * judging_s + steps / IMITATOR_STEPS_PER_S[recipe.policy.network]
    iterations = max(1.0, steps / recipe.dagger.steps_per_iteration)
    # Every iteration learns all that was collected until then.
    learned = recipe.cloning.epochs * steps * (iterations + 1) / 2
    return (
        steps / DAGGER_LABELS_PER_S
        + DAGGER_EPOCHS_SHARE * learned / CLONING_OBSERVATIONS_PER_S[recipe.policy.network]
        + iterations * judging_s
    )


def _learning_seconds(reward: RewardRecipe) -> float:
    """Return what the training of one reward network takes."""
    update_s = REWARD_UPDATE_S + _observations_per_update(reward) / REWARD_OBSERVATIONS_PER_S
    return reward.updates * update_s


def _observations_per_update(reward: RewardRecipe) -> float:
    if reward.method == "fast":
        return N_DEMONSTRATIONS * MEAN_STEPS / reward.observation_stride
    fragment = (reward.fragment_min_steps + reward.fragment_max_steps) / 2
    return 2 * reward.pairs_per_update * fragment / reward.observation_stride


def overall_progress(run: RunRow) -> float:
    """Return how much of a run is done, 0..1, weighting its stages by the time they take."""
    if run.status == RunStatus.DONE:
        return 1.0
    stages = stages_of(run)
    try:
        weights = expected_seconds(recipe_from_dict(run.recipe), run.steps)
    except Invalid:
        # A recipe of another version of Tril: the run is still listed.
        weights = dict.fromkeys(stages, 1.0)
    done = sum(weights[stage] for stage in stages if stage in run.finished_stages)
    if run.stage in stages and run.stage not in run.finished_stages:
        done += weights[run.stage] * run.stage_done
    return min(1.0, done / sum(weights[stage] for stage in stages))
