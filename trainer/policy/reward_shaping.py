"""What a policy is paid: the learned reward R in one of four shapes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from trainer.reward.model import RewardModel
from tril.game.episode import DEATHS, EndReason
from tril.recipes import PolicyRecipe

Rewards = npt.NDArray[np.float32]


@dataclass(frozen=True)
class RewardShaping:
    """The reward of a step, from R of the states before and after it.

    "sigmoid" is the thesis's (section 5.1). It pays about as much for being alive as for the
    behaviour. "level" pays R scaled so that the demonstrations' beginnings give 0 and the best
    ones' ends give 1, without a bound, so that a step of progress counts for the rest of the game.
    "difference" pays what the level has gained, once (a potential, Ng et al. 1999, without the
    discount). "softplus" pays log(1 + exp(R)): where R is the logit of GAIL's discriminator D that
    a state is demonstrated, that is -log(1 - D), the negative of the cost in Ho and Ermon 2016
    (algorithm 1), whose D is the probability that a state is the policy's.

    Attributes:
        model: The reward model, for its levels.
        kind: "sigmoid", "level", "difference" or "softplus".
        death_penalty: Subtracted in the step in which the player is hit.
        scale: What all of it is multiplied by.
    """

    model: RewardModel
    kind: str
    death_penalty: float
    scale: float = 1.0

    @classmethod
    def of(cls, model: RewardModel, recipe: PolicyRecipe) -> RewardShaping:
        """The payment that a recipe asks for."""
        return cls(model, recipe.reward, recipe.death_penalty, recipe.reward_scale)

    @property
    def needs_before(self) -> bool:
        """Whether R of the state before a step matters."""
        return self.kind == "difference"

    def pay(self, before: Rewards, reached: Rewards, died: npt.NDArray[np.bool_]) -> Rewards:
        """Return the reward of each step, float32 (N,).

        Args:
            before: R of the states before the steps, float32 (N,).
            reached: R of the states that the steps led to, float32 (N,): of the episode's last
                state where the step ended it.
            died: Whether the player was hit in the step, bool (N,).
        """
        if self.kind == "sigmoid":
            paid = 0.5 * (1.0 + np.tanh(0.5 * reached))
        elif self.kind == "softplus":
            paid = np.logaddexp(0.0, reached)
        elif self.kind == "level":
            paid = self.model.level(reached)
        else:
            paid = self.model.level(reached) - self.model.level(before)
        return np.asarray(self.scale * (paid - self.death_penalty * died), np.float32)

    def total(self, states: Rewards, end: EndReason) -> float:
        """Return what a whole game is paid.

        Args:
            states: R of its states, float32 (T + 1,), the start's first.
            end: Why it ended.
        """
        died = np.zeros(len(states) - 1, np.bool_)
        died[-1:] = end in DEATHS
        return float(self.pay(states[:-1], states[1:], died).sum(dtype=np.float64))
