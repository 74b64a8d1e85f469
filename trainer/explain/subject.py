"""What an attention map explains: a number that a network computes from an observation."""

from __future__ import annotations

from typing import Protocol

import numpy as np
import numpy.typing as npt
import torch
from torch import Tensor

from trainer.nn.devices import CPU, forward_batch
from tril.play.observation import Observation, Observations


class Subject(Protocol):
    """A number that depends on an observation: R of a reward model, or the odds of an action."""

    def score(self, observations: Observations) -> npt.NDArray[np.float32]:
        """Return the numbers, float32 (N,), of observations, uint8 (N, 4, 84, 84)."""

    def of_pixels(self, pixels: Tensor) -> Tensor:
        """Return the numbers, float32 (N,), differentiable, of float32 (N, 4, 84, 84)."""


class Chooser(Protocol):
    """What chooses actions: a trainer.policy.networks.Policy."""

    def probabilities(self, observations: Observations) -> npt.NDArray[np.float32]:
        """Return the probability of each action, float32 (N, 6)."""

    def logits(self, pixels: Tensor) -> Tensor:
        """Return the logit of each action, float32 (N, 6), differentiable."""


class ActionOdds:
    """The log odds that a policy chooses an action, log(p / (1 - p)) with the natural logarithm.

    Other than the log probability they do not level off where the policy is sure, and other than
    the network's output for the action they do not change if those of all actions do.

    Args:
        policy: The policy, on the CPU.
        action: The action.
    """

    def __init__(self, policy: Chooser, action: int) -> None:
        self.action = action
        self._policy = policy

    @classmethod
    def of_choice(cls, policy: Chooser, observation: Observation) -> ActionOdds:
        """Return the odds of the action that a policy finds most likely in a state."""
        probabilities = policy.probabilities(observation[None])
        return cls(policy, int(probabilities[0].argmax()))

    def score(self, observations: Observations) -> npt.NDArray[np.float32]:
        """See Subject."""
        parts = torch.split(torch.from_numpy(observations), forward_batch(CPU))
        with torch.inference_mode():
            return torch.cat([self.of_pixels(part) for part in parts]).numpy()

    def of_pixels(self, pixels: Tensor) -> Tensor:
        """See Subject."""
        logits = self._policy.logits(pixels)
        chosen = logits[:, self.action]
        unchosen = torch.cat([logits[:, : self.action], logits[:, self.action + 1 :]], 1)
        return chosen - unchosen.logsumexp(1)
