"""The published sanity experiments: does a learned reward follow the quantity ranked by?

T-REX (Brown et al. 2019, section 5 and figure 3) ranks games by their score, the thesis (section
5.1 and figure 5.1) by the missiles fired. The games are those of players of growing skill: one
policy at several checkpoints of its training. The reward is learned from games of the early
checkpoints; games of later ones extrapolate.

Learning is privileged here: the player is rewarded with the true quantity, which is read from the
game's memory, and the ranking is made from it. No behaviour is taught this way.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import gymnasium
import numpy as np
from stable_baselines3 import PPO
from stable_baselines3.common.vec_env import DummyVecEnv, SubprocVecEnv, VecEnv, VecNormalize

import tril.play.env
from trainer.policy.evaluation import EvaluatedGame, play
from trainer.policy.networks import Policy, ScreenPolicy, policy_arguments
from trainer.progress import Progress, ScaledProgress
from trainer.reporting.skilled_games import (
    Experiment,
    Extrapolation,
    Quantity,
    SkilledGame,
    tiers_by,
)
from trainer.reward.model import predicted_return
from trainer.reward.preference_dataset import PreferenceDataset
from trainer.reward.reward_trainer import train_reward_model
from tril.errors import Invalid
from tril.games.base import spread_starts
from tril.games.space_invaders import SPACE_INVADERS
from tril.recipes import Recipe
from tril.recording import trajectory


@dataclass(frozen=True)
class SkillPlan:
    """How the player is trained, and which of its games a reward is learned from.

    Attributes:
        checkpoints: Training steps after which games of the player are taken, ascending.
        demonstrating: Number of checkpoints, from the first, whose games may be ranked.
        games: Games per checkpoint, from training starts, with sampled actions.
        demonstrations: Games that are ranked, spread evenly over the true quantity.
        parallel_games: Environments that the player trains in.
        rollout_steps: Steps per environment between two updates.
    """

    checkpoints: tuple[int, ...] = (
        0,
        16_384,
        32_768,
        49_152,
        65_536,
        131_072,
        196_608,
        262_144,
    )
    demonstrating: int = 5
    games: int = 12
    demonstrations: int = 12
    parallel_games: int = 8
    rollout_steps: int = 128


def extrapolate(
    quantity: Quantity,
    recipe: Recipe,
    training_seed: int,
    progress: Progress,
    plan: SkillPlan | None = None,
) -> Extrapolation:
    """Train a player, rank its games by its reward, and learn a reward model from the ranking.

    Args:
        quantity: The player's reward, by which its games are ranked.
        recipe: Recipe of the reward; there are no perfect demonstrations.
        training_seed: Feeds every random choice.
        progress: Told of the player's training and the reward model's, half of the work each.
        plan: Checkpoints and games; SkillPlan's defaults if None.

    Raises:
        Invalid: All games that may demonstrate are worth the same.
        RunCancelled: Raised by ``progress``.
    """
    plan = plan or SkillPlan()
    played = _play(quantity, training_seed, ScaledProgress(progress, 0.0, 0.5), plan)
    worths = [_worth(quantity, game) for _, game in played]
    able = [
        i for i, (step, _) in enumerate(played) if step in plan.checkpoints[: plan.demonstrating]
    ]
    chosen = spread(able, worths, plan.demonstrations)
    tiers = tiers_by([worths[index] for index in chosen])
    if len(tiers) < 2:
        raise Invalid(
            f"All games that could demonstrate are worth {worths[chosen[0]]}: the player needs more"
            " training steps before they differ."
        )
    trajectories = [trajectory(game.recording) for _, game in played]
    dataset = PreferenceDataset.from_demonstrations(
        [trajectories[index] for index in chosen], tiers, recipe.reward
    )
    model = train_reward_model(dataset, training_seed, ScaledProgress(progress, 0.5, 1.0))
    return Extrapolation(
        Experiment.of(quantity, recipe, training_seed),
        tuple(
            SkilledGame(
                step,
                worths[index],
                predicted_return(model, trajectories[index].observations),
                index in chosen,
            )
            for index, (step, _) in enumerate(played)
        ),
    )


def spread(able: Sequence[int], worths: Sequence[float], count: int) -> list[int]:
    """Return ``count`` of the ``able`` indices, spread evenly over the order of their worths.

    The lowest and the highest are always among them; of fewer than ``count`` all are taken.
    """
    ordered = sorted(able, key=lambda index: (worths[index], index))
    places = np.linspace(0, len(ordered) - 1, min(count, len(ordered)))
    return [ordered[round(place)] for place in places]


def _worth(quantity: Quantity, game: EvaluatedGame) -> int:
    return int(game.score) if quantity == "points" else game.counters[quantity]


def _play(
    quantity: Quantity, training_seed: int, progress: Progress, plan: SkillPlan
) -> list[tuple[int, EvaluatedGame]]:
    """Train a player and return the games of each checkpoint with its training steps."""
    starts = spread_starts(SPACE_INVADERS.starts.training, plan.games)
    games: list[tuple[int, EvaluatedGame]] = []
    total = plan.checkpoints[-1]
    env = VecNormalize(_environments(quantity, plan), norm_obs=False)
    try:
        player = PPO(
            ScreenPolicy,
            env,
            learning_rate=3e-4,
            n_steps=plan.rollout_steps,
            batch_size=max(1, plan.rollout_steps * plan.parallel_games // 4),
            n_epochs=4,
            ent_coef=0.01,
            seed=training_seed,
            device="cpu",
            policy_kwargs=policy_arguments("small"),
        )
        for number, steps in enumerate(plan.checkpoints):
            missing = steps - player.num_timesteps
            if missing > 0:
                player.learn(
                    missing,
                    callback=lambda values, _: _tell(progress, values["self"], total),
                    reset_num_timesteps=False,
                )
            player.policy.set_training_mode(False)
            assert isinstance(player.policy, ScreenPolicy)
            policy = Policy(player.policy)
            seed = training_seed + number
            played = play(SPACE_INVADERS, policy, starts, "sampled", sampling_seed=seed)
            games += [(steps, game) for game in played]
    finally:
        env.close()
    progress.advance(total, total)
    return games


def _tell(progress: Progress, player: Any, total: int) -> bool:
    progress.advance(min(player.num_timesteps, total), total)
    return True


def _environments(quantity: Quantity, plan: SkillPlan) -> VecEnv:
    def make() -> gymnasium.Env[Any, Any]:
        return gymnasium.make(
            tril.play.env.ENV_ID, reward="score" if quantity == "points" else quantity
        )

    makers = [make] * plan.parallel_games
    return DummyVecEnv(makers) if plan.parallel_games == 1 else SubprocVecEnv(makers)
