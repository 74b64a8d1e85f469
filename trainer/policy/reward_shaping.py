"""Shapes of the learned reward R that policies are trained on."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from trainer.reward.model import RewardModel
from tril.recipes import PolicyRecipe

Rewards = npt.NDArray[np.float32]


@dataclass(frozen=True)
class RewardShaping:
    """The reward of a step, from R of the states before and after it.

    "sigmoid", the thesis's (section 5.1), rewards survival about as much as the behaviour. "level"
    is R scaled to 0 at the demonstrations' beginnings and 1 at the best ones' ends, unbounded, so
    that a step of progress counts for the rest of the game. "difference" is the gain in level,
    which counts progress once (potential-based shaping, Ng et al. 1999, without the discount).
    "softplus" is log(1 + exp(R)): where R is the logit of GAIL's discriminator D that a state is
    demonstrated, this is -log(1 - D), the negative of the cost in Ho and Ermon 2016 (algorithm 1),
    whose D is the probability that a state is the policy's.

    Attributes:
        model: The reward model.
        kind: "sigmoid", "level", "difference" or "softplus".
        death_penalty: Subtracted in the step in which the player is hit.
        death_forfeit: Share of the level reached, as far as it is above 0, that is subtracted
            there, too.
        scale: Factor on the result.
    """

    model: RewardModel
    kind: str
    death_penalty: float
    scale: float = 1.0
    death_forfeit: float = 0.0

    @classmethod
    def of(cls, model: RewardModel, recipe: PolicyRecipe) -> RewardShaping:
        """Return the reward shaping of a recipe."""
        return cls(
            model, recipe.reward, recipe.death_penalty, recipe.reward_scale, recipe.death_forfeit
        )

    def shape(self, previous: Rewards, reached: Rewards, died: npt.NDArray[np.bool_]) -> Rewards:
        """Return the reward of each step, float32 (N,).

        Args:
            previous: R of the states before the steps, float32 (N,).
            reached: R of the states that the steps led to, float32 (N,): of the episode's last
                state where the step ended it.
            died: Whether the player was hit in the step, bool (N,).
        """
        if self.kind == "sigmoid":
            shaped = 0.5 * (1.0 + np.tanh(0.5 * reached))
        elif self.kind == "softplus":
            shaped = np.logaddexp(0.0, reached)
        elif self.kind == "level":
            shaped = self.model.level(reached)
        else:
            shaped = self.model.level(reached) - self.model.level(previous)
        lost = self.death_penalty * died
        if self.death_forfeit:
            lost = lost + self.death_forfeit * died * self.model.level(previous).clip(0.0)
        return np.asarray(self.scale * (shaped - lost), np.float32)

    def shaped_return(self, rewards: Rewards, died: bool) -> float:
        """Return the sum of the shaped rewards of a whole game.

        Args:
            rewards: R of its states, float32 (T + 1,), from the start on.
            died: Whether the player died at its end.
        """
        deaths = np.zeros(len(rewards) - 1, np.bool_)
        deaths[-1:] = died
        return float(self.shape(rewards[:-1], rewards[1:], deaths).sum(dtype=np.float64))
