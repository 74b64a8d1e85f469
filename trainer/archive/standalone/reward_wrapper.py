"""A learned reward of Tril for any Gymnasium environment with Tril's observations.

Needs gymnasium, torch, safetensors and numpy, and nothing of Tril.

    from reward_wrapper import LearnedReward
    env = LearnedReward(env, "reward/reward-model.safetensors", own_share=0.0)

An observation is uint8 (4, 84, 84): the last four steps' screens, oldest first. A step is four
frames with the same action; its screen is the pixel-wise maximum of its last two frames in
grayscale, averaged over areas to 84x84, with the rows of the score set to 0.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any, SupportsFloat

import gymnasium
import numpy as np
import numpy.typing as npt
import torch
from safetensors import safe_open
from torch import Tensor, nn
from torch.nn import functional as F

Observation = npt.NDArray[np.uint8]


class RewardNetwork(nn.Module):
    """Four convolutions and two linear layers, with leaky ReLU between (T-REX).

    Args:
        n_flags: Size of a further layer below the output, of probabilities; 0 leaves it out.
        n_features: Number of values that the output is linear in.
        order: "sweeps" or "gaps" if some of these say in which order aliens were hit, else "".
    """

    def __init__(self, n_flags: int, n_features: int, order: str) -> None:
        super().__init__()
        self.order = order
        self.convolutions = nn.ModuleList(
            [
                nn.Conv2d(4, 16, kernel_size=7, stride=3),
                nn.Conv2d(16, 16, kernel_size=5, stride=2),
                nn.Conv2d(16, 16, kernel_size=3, stride=1),
                nn.Conv2d(16, 16, kernel_size=3, stride=1),
            ]
        )
        self.hidden = nn.Linear(784, 64)
        self.memory = nn.Linear(64, n_flags) if n_flags else None
        self.output = nn.Linear(n_features, 1)

    def forward(self, observations: Tensor) -> Tensor:
        """Return R, float32 (N,), of observations, uint8 (N, 4, 84, 84)."""
        values = observations.float() / 255.0
        for layer in self.convolutions:
            values = F.leaky_relu(layer(values))
        values = F.leaky_relu(self.hidden(values.flatten(1)))
        if self.memory is not None:
            values = self.memory(values).sigmoid()
            grid = values.reshape(-1, 6, 6) if self.order else values
            if self.order == "sweeps":
                # Whether the first two, three, ... six aliens of a row of the grid are all gone.
                values = torch.cat([values, (1.0 - grid).cumprod(2)[:, :, 1:].flatten(1)], 1)
            elif self.order == "gaps":
                # Where an alien of the grid is left and its right neighbour is not.
                gaps = 0.5 * grid[:, :, :-1] * (1.0 - grid[:, :, 1:])
                values = torch.cat([values, gaps.flatten(1)], 1)
        rewards: Tensor = self.output(values).squeeze(1)
        return rewards


class RewardModel:
    """R(observation), the standardised output of a network.

    Args:
        path: The file of weights.

    Raises:
        ValueError: The file holds something else.
    """

    def __init__(self, path: str | Path) -> None:
        with safe_open(str(path), framework="pt") as file:
            metadata = file.metadata() or {}
            if (metadata.get("format"), metadata.get("version")) != ("tril-reward-model", "1"):
                raise ValueError(f"{path} has no reward model that this program can read.")
            weights = {name: file.get_tensor(name).float() for name in file.keys()}  # noqa: SIM118
        model = json.loads(metadata["model"])
        if len(model["offsets"]) != 1:
            raise ValueError(f"{path} has an ensemble, which this program does not read.")
        (self._offset,), (self._scale,) = model["offsets"], model["scales"]
        layers = {
            name.removeprefix("0."): w for name, w in weights.items() if name.startswith("0.")
        }
        n_flags, n_features = (
            len(layers.get("memory.bias", ())),
            layers["output.weight"].shape[1],
        )
        order = model.get("order", "gaps") if n_features > n_flags > 0 else ""
        self._network = RewardNetwork(n_flags, n_features, order)
        self._network.load_state_dict(layers)
        self._network.eval()

    def score(self, observations: Observation) -> npt.NDArray[np.float32]:
        """Return R, float32 (N,), of observations, uint8 (N, 4, 84, 84)."""
        with torch.inference_mode():
            batch = torch.from_numpy(np.ascontiguousarray(observations))
            rewards: npt.NDArray[np.float32] = (
                (self._network(batch) - self._offset) / self._scale
            ).numpy()
            return rewards


class LearnedReward(gymnasium.Wrapper[Observation, Any, Observation, Any]):
    """Adds the learned reward of the state that each step leads to.

    It is also in the step's info, as "learned_reward".

    Args:
        env: An environment with observations of shape (4, 84, 84) and dtype uint8.
        path: The reward model's file of weights.
        own_share: Factor of the environment's own reward.
        learned_share: Factor of the learned reward.

    Raises:
        ValueError: The environment has other observations.
    """

    def __init__(
        self,
        env: gymnasium.Env[Observation, Any],
        path: str | Path,
        own_share: float = 1.0,
        learned_share: float = 1.0,
    ) -> None:
        super().__init__(env)
        space = env.observation_space
        if space.shape != (4, 84, 84) or space.dtype != np.uint8:
            raise ValueError(
                "Expected an environment with observations of shape (4, 84, 84) and dtype uint8,"
                f" got {space}."
            )
        self._model = RewardModel(path)
        self._own_share = own_share
        self._learned_share = learned_share

    def step(self, action: Any) -> tuple[Observation, SupportsFloat, bool, bool, dict[str, Any]]:
        """Step the environment and add the learned reward to its own."""
        observation, own_reward, terminated, truncated, info = self.env.step(action)
        learned = float(self._model.score(observation[None])[0])
        reward = self._own_share * float(own_reward) + self._learned_share * learned
        return observation, reward, terminated, truncated, info | {"learned_reward": learned}
