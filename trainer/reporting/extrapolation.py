"""The published sanity experiments: does a learned reward follow what the games were ranked by?

T-REX (Brown et al. 2019, section 5 and figure 3) ranks games by their score, the thesis (section
5.1 and figure 5.1) by the missiles fired. The games are those of players of growing skill: one
policy, as it is after more and more training. The reward is learned from the less skilled ones'
games; the others' go beyond what it has seen.

Here learning is privileged: the players are paid the true quantity, which is read off the game's
memory, and the ranking is made from it. No behaviour is taught so.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

import gymnasium
import numpy as np
from stable_baselines3 import PPO
from stable_baselines3.common.vec_env import DummyVecEnv, SubprocVecEnv, VecEnv, VecNormalize

import tril.game.env
from trainer.policy.evaluation import EvaluatedGame, play
from trainer.policy.networks import Policy, ScreenPolicy, policy_arguments
from trainer.progress import Progress, ScaledProgress
from trainer.reporting.figures import ReturnsGroup, returns_scatter
from trainer.reward.model import predicted_return
from trainer.reward.preference_dataset import PreferenceDataset
from trainer.reward.reward_trainer import train_reward_model
from tril.errors import Invalid
from tril.game.env import points_of
from tril.game.starts import spread_starts
from tril.ranking import kendall_tau
from tril.recipes import RewardRecipe
from tril.recording import trajectory

Quantity = Literal["points", "shots"]
QUANTITIES: dict[Quantity, str] = {
    "points": "points of the aliens shot",
    "shots": "missiles fired",
}


@dataclass(frozen=True)
class SkillPlan:
    """How players of growing skill are made, and which of their games a reward is learned from.

    Attributes:
        checkpoints: After how many of its training steps the player's games are taken, ascending.
        demonstrating: How many of the checkpoints, from the first, demonstrate.
        games: Games of each checkpoint, from training starts, its actions drawn by chance.
        demonstrations: Games that are ranked: of the demonstrating checkpoints' spread evenly over
            their true quantities.
        parallel_games: Games that the player trains on side by side.
        rollout_steps: Steps of each between two updates.
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


@dataclass(frozen=True)
class SkilledGame:
    """A game of a player of some skill.

    Attributes:
        checkpoint: After how many training steps it was played.
        true_quantity: Points, or missiles fired.
        predicted_return: Sum of R over the game.
        demonstrated: Whether the reward was learned from it.
    """

    checkpoint: int
    true_quantity: int
    predicted_return: float
    demonstrated: bool


@dataclass(frozen=True)
class Extrapolation:
    """How predicted returns follow a true quantity.

    Attributes:
        quantity: Which.
        games: The demonstrations and all other games.
    """

    quantity: Quantity
    games: tuple[SkilledGame, ...]

    @property
    def demonstrations(self) -> tuple[SkilledGame, ...]:
        """The games that the reward was learned from."""
        return tuple(game for game in self.games if game.demonstrated)

    @property
    def unseen(self) -> tuple[SkilledGame, ...]:
        """The others that are worth no more than the best demonstration."""
        return tuple(g for g in self.games if not g.demonstrated and not self._is_beyond(g))

    @property
    def beyond(self) -> tuple[SkilledGame, ...]:
        """The others that are worth more than any demonstration."""
        return tuple(game for game in self.games if self._is_beyond(game))

    def _is_beyond(self, game: SkilledGame) -> bool:
        return game.true_quantity > max(one.true_quantity for one in self.demonstrations)


def extrapolate(
    quantity: Quantity,
    recipe: RewardRecipe,
    training_seed: int,
    progress: Progress,
    plan: SkillPlan | None = None,
) -> Extrapolation:
    """Train a player, rank its games by what it was paid for, and learn a reward from the ranking.

    Args:
        quantity: What it is paid and what its games are ranked by.
        recipe: How the reward is learned. There are no perfect games.
        training_seed: Feeds every random choice.
        progress: Told of the player's training and the reward's, half of the work each.
        plan: Which players and games; by default the ordinary one.

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
    tiers = _tiers([worths[index] for index in chosen])
    if len(tiers) < 2:
        raise Invalid(
            f"All games that could demonstrate are worth {worths[chosen[0]]}: the player needs more"
            " training steps before they differ."
        )
    seen = [trajectory(game.recording) for _, game in played]
    dataset = PreferenceDataset.from_demonstrations([seen[i] for i in chosen], tiers, recipe)
    model = train_reward_model(dataset, training_seed, ScaledProgress(progress, 0.5, 1.0))
    return Extrapolation(
        quantity,
        tuple(
            SkilledGame(
                step,
                worths[index],
                predicted_return(model, seen[index].observations),
                index in chosen,
            )
            for index, (step, _) in enumerate(played)
        ),
    )


def spread(able: Sequence[int], worths: Sequence[float], count: int) -> list[int]:
    """Return ``count`` of the ``able`` indices, evenly over the order of their worths.

    The least and the most worthy are always among them; of fewer than ``count`` all are taken.
    """
    ordered = sorted(able, key=lambda index: (worths[index], index))
    places = np.linspace(0, len(ordered) - 1, min(count, len(ordered)))
    return [ordered[round(place)] for place in places]


def extrapolation_picture(found: Extrapolation) -> bytes:
    """Draw predicted return against true quantity as PNG, as T-REX's figure 3 does."""
    groups = (
        ("demonstrations", "#c2371f", found.demonstrations),
        ("unseen games within their range", "#0067b0", found.unseen),
        ("unseen games beyond it", "#6a4c93", found.beyond),
    )
    return returns_scatter(
        [
            ReturnsGroup(
                label,
                colour,
                "o",
                label == "demonstrations",
                [game.true_quantity for game in games],
                [game.predicted_return for game in games],
            )
            for label, colour, games in groups
            if games
        ],
        QUANTITIES[found.quantity],
        set_apart=False,
    )


def tau_of(games: Sequence[SkilledGame]) -> float | None:
    """Return Kendall's tau-b between true quantity and predicted return; None if all are equal."""
    tiers = _tiers([game.true_quantity for game in games])
    if len(tiers) < 2:
        return None
    return kendall_tau(tiers, [game.predicted_return for game in games])


def _tiers(worths: Sequence[float]) -> list[list[int]]:
    """Return the indices in tiers of equal worth, best first."""
    found: dict[float, list[int]] = defaultdict(list)
    for index, worth in enumerate(worths):
        found[worth].append(index)
    return [found[worth] for worth in sorted(found, reverse=True)]


def _worth(quantity: Quantity, game: EvaluatedGame) -> int:
    return points_of(game.hits) if quantity == "points" else game.shots


def _play(
    quantity: Quantity, training_seed: int, progress: Progress, plan: SkillPlan
) -> list[tuple[int, EvaluatedGame]]:
    """Train a player on the quantity and return games of each checkpoint with its steps."""
    starts = spread_starts(plan.games)
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
            played = play(policy, starts, "sampled", sampling_seed=training_seed + number)
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
        return gymnasium.make(tril.game.env.ENV_ID, reward=quantity)

    makers = [make] * plan.parallel_games
    return DummyVecEnv(makers) if plan.parallel_games == 1 else SubprocVecEnv(makers)
