"""stable-baselines3's rollout buffer without its copies."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
import torch
from gymnasium import spaces
from stable_baselines3.common.buffers import RolloutBuffer
from torch import Tensor

from trainer.nn.screens import channels_last_screens, take_screens
from tril.play.observation import Observations


class Minibatch(NamedTuple):
    """A random part of a rollout; see stable-baselines3's RolloutBufferSamples.

    Attributes:
        inputs: Inputs of the policy: uint8 (B, 4, 84, 84) in channels-last order, or outputs of
            frozen convolutions, float32 (B, N).
        actions: int64 (B,).
        old_log_probs: Log probabilities of the actions when they were sampled, float32 (B,).
        advantages: float32 (B,).
        returns: Targets of the values, float32 (B,).
        indices: Indices in the rollout, int64 (B,).
    """

    inputs: Tensor
    actions: Tensor
    old_log_probs: Tensor
    advantages: Tensor
    returns: Tensor
    indices: Tensor


class ScreenRolloutBuffer(RolloutBuffer):
    """A RolloutBuffer whose observations are written once and read once.

    stable-baselines3 allocates the buffer again for each rollout and copies each observation twice
    when it is added, again with the first minibatch, and each minibatch once more. Here the memory
    is reused, observations are written in channels-last order as the convolutions read them, and a
    minibatch is gathered once, still uint8.

    Games are added in parts (see VectorGame): ``put_screens`` and ``put_actions`` write a step of
    some of them, ``put_rewards`` all rewards at once. Beside the states that the policy acted on,
    the buffer has the last ones, which follow the rollout's last step.
    """

    def __init__(
        self,
        buffer_size: int,
        observation_space: spaces.Space[Any],
        action_space: spaces.Space[Any],
        device: torch.device | str = "cpu",
        gae_lambda: float = 1.0,
        gamma: float = 0.99,
        n_envs: int = 1,
    ) -> None:
        assert isinstance(observation_space, spaces.Box)
        channels, height, width = observation_space.shape
        self._screens = torch.empty(
            (buffer_size + 1, n_envs, height, width, channels), dtype=torch.uint8
        )
        self._allocated = False
        super().__init__(
            buffer_size,
            observation_space,
            action_space,
            device,
            gae_lambda=gae_lambda,
            gamma=gamma,
            n_envs=n_envs,
        )

    def reset(self) -> None:
        """Empty the buffer; its memory stays."""
        if not self._allocated:
            shape = (self.buffer_size, self.n_envs)
            self.actions = np.zeros((*shape, 1), np.int64)
            self.rewards = np.zeros(shape, np.float32)
            self.returns = np.zeros(shape, np.float32)
            self.episode_starts = np.zeros(shape, np.float32)
            self.values = np.zeros(shape, np.float32)
            self.log_probs = np.zeros(shape, np.float32)
            self.advantages = np.zeros(shape, np.float32)
            self._allocated = True
        self.pos = 0
        self.full = False

    def begin(self, observations: Observations) -> None:
        """Empty the buffer and write all games' states before the first step.

        Args:
            observations: uint8 (games, 4, 84, 84).
        """
        self.reset()
        self.put_screens(0, range(self.n_envs), observations)

    def put_screens(self, step: int, games: range, observations: Observations) -> None:
        """Write the states before a step.

        Args:
            step: Number of the step; the buffer's size for the states after the last one.
            games: Games of the states.
            observations: uint8 (games, 4, 84, 84).
        """
        channels_last_screens(observations, self._of(step, games).numpy())

    def screens_of(self, step: int, games: range) -> Tensor:
        """Return some games' states before a step, in channels-last order."""
        return self._of(step, games).permute(0, 3, 1, 2)

    def _of(self, step: int, games: range) -> Tensor:
        return self._screens[step, games.start : games.stop]

    def put_actions(
        self,
        step: int,
        games: range,
        actions: npt.NDArray[np.int64],
        values: Tensor,
        log_probs: Tensor,
    ) -> None:
        """Write the games' actions in a step, the values before it and the log probabilities."""
        columns = slice(games.start, games.stop)
        self.actions[step, columns, 0] = actions
        self.values[step, columns] = values.numpy()
        self.log_probs[step, columns] = log_probs.numpy()

    def put_rewards(self, rewards: npt.NDArray[np.float32]) -> None:
        """Write the rewards of all steps, float32 (steps, games), which completes the rollout."""
        self.rewards[:] = rewards
        self.pos = self.buffer_size
        self.full = True

    @property
    def screens(self) -> Tensor:
        """States before all steps, uint8 (steps * games, 4, 84, 84), in channels-last order."""
        return self._screens[:-1].flatten(0, 1).permute(0, 3, 1, 2)

    @property
    def all_screens(self) -> Tensor:
        """``screens``, then ``last_screens``, uint8 ((steps + 1) * games, 4, 84, 84)."""
        return self._screens.flatten(0, 1).permute(0, 3, 1, 2)

    @property
    def last_screens(self) -> Tensor:
        """The states after the last step, uint8 (games, 4, 84, 84), in channels-last order."""
        return self._screens[-1].permute(0, 3, 1, 2)

    def minibatches(
        self, inputs: Tensor, batch_size: int, rng: np.random.Generator
    ) -> Iterator[Minibatch]:
        """Yield the rollout once on the buffer's device, in an order drawn from ``rng``.

        Args:
            inputs: ``screens``, or what frozen convolutions make of them, (steps * games, N).
            batch_size: Steps of a minibatch.
            rng: Source of the order.
        """
        if not self.full:
            raise RuntimeError("The rollout is not complete yet.")
        inputs = inputs.to(self.device)
        actions = torch.from_numpy(self.actions.reshape(-1)).to(self.device)
        log_probs = torch.from_numpy(self.log_probs.reshape(-1)).to(self.device)
        advantages = torch.from_numpy(self.advantages.reshape(-1)).to(self.device)
        returns = torch.from_numpy(self.returns.reshape(-1)).to(self.device)
        order = torch.from_numpy(rng.permutation(len(inputs))).to(self.device)
        for begin in range(0, len(order), batch_size):
            indices = order[begin : begin + batch_size]
            yield Minibatch(
                inputs[indices] if inputs.dim() == 2 else take_screens(inputs, indices),
                actions[indices],
                log_probs[indices],
                advantages[indices],
                returns[indices],
                indices,
            )
