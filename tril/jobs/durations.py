"""What the stages of a run take on two 2.5 GHz cores, by rates measured there."""

from __future__ import annotations

from tril.recipes import Recipe, RewardRecipe
from tril.stages import Stage
from tril.store.training.evaluations import ACTION_SELECTIONS, POLICIES

DEMONSTRATIONS_S = 30.0
TRAJECTORIES_S = 6.0
CHECK_S = 4.0
ATTENTION_S = 8.0
N_DEMONSTRATIONS = 12
MEAN_STEPS = 250
"""Steps of a typical demonstration or evaluation game."""

REWARD_OBSERVATIONS_PER_S = 4_500.0
REWARD_READINGS_PER_S = 6_000.0
"""Observations that a pretrained reward model's layers read, each once."""
REWARD_UPDATE_S = 0.003
"""Overhead of an update of the reward model, besides its observations."""
GIBBS_PASS_S = 0.0003
"""A pass of Gibbs sampling over the six columns, with a dozen ranked games."""
VOCABULARY_S = 60.0
"""Varied play, looked at step by step; a third of it where the vocabulary was made before."""
STATEMENT_UPDATE_S = 0.04
CLONING_OBSERVATIONS_PER_S = {"nature": 1_600.0, "small": 4_200.0}
IMITATOR_STEPS_PER_S = {"nature": 400.0, "small": 750.0}
FROZEN_STEPS_PER_S = 2_000.0
"""With the convolutions of the small network as they are."""
EVALUATION_STEPS_PER_S = 900.0


def expected_seconds(recipe: Recipe, steps: int) -> dict[Stage, float]:
    """Return the seconds that each stage takes with a recipe and training steps of the imitator."""
    reward = recipe.reward
    cloning_rate = CLONING_OBSERVATIONS_PER_S[recipe.cloning.network]
    n_starts = len(recipe.evaluation.start_numbers) + len(recipe.evaluation.further_start_numbers)
    games = n_starts * len(POLICIES) * len(ACTION_SELECTIONS)
    demonstrated = N_DEMONSTRATIONS * MEAN_STEPS
    return {
        Stage.DEMONSTRATIONS: DEMONSTRATIONS_S,
        Stage.TRAJECTORIES: TRAJECTORIES_S,
        Stage.REWARD: 1.0 + _reading_seconds(reward) + _learning_seconds(reward),
        Stage.CHECK: CHECK_S + _checking_seconds(reward),
        Stage.CLONE: 1.0 + recipe.cloning.epochs * demonstrated / cloning_rate,
        Stage.IMITATOR: 2.0 + _imitator_seconds(recipe, steps),
        Stage.EVALUATION: 4.0 + games * MEAN_STEPS / EVALUATION_STEPS_PER_S,
        Stage.ATTENTION: ATTENTION_S,
    }


def _imitator_seconds(recipe: Recipe, steps: int) -> float:
    judging_s = recipe.policy.snapshot_episodes * MEAN_STEPS / EVALUATION_STEPS_PER_S
    snapshots = 1 + sum(step <= steps for step in recipe.policy.snapshot_steps)
    rate = IMITATOR_STEPS_PER_S[recipe.policy.network]
    if recipe.policy.freeze_convolutions:
        rate = max(rate, FROZEN_STEPS_PER_S)
    return snapshots * judging_s + steps / rate


def _reading_seconds(reward: RewardRecipe) -> float:
    """Return the seconds in which pretrained layers read the demonstrations."""
    if not reward.pretrained:
        return 0.0
    # As many perfect ones as ranked ones.
    return 2 * N_DEMONSTRATIONS * MEAN_STEPS / REWARD_READINGS_PER_S


def _learning_seconds(reward: RewardRecipe) -> float:
    """Return the seconds that the training of one reward network takes."""
    if reward.method == "posterior":
        return reward.updates * GIBBS_PASS_S
    if reward.method == "statement":
        return VOCABULARY_S + reward.updates * STATEMENT_UPDATE_S
    update_s = REWARD_UPDATE_S + _observations_per_update(reward) / REWARD_OBSERVATIONS_PER_S
    return reward.updates * update_s


def _checking_seconds(reward: RewardRecipe) -> float:
    """Return the seconds that the check's folds take; a statement is only inferred again."""
    return 0.0 if reward.method == "statement" else reward.folds * _learning_seconds(reward.of_fold)


def _observations_per_update(reward: RewardRecipe) -> float:
    fragment = (reward.fragment_min_steps + reward.fragment_max_steps) / 2
    return 2 * reward.pairs_per_update * fragment / reward.observation_stride
