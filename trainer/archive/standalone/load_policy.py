"""Loads a policy that Tril trained. Needs torch, safetensors and numpy, and nothing of Tril.

    from load_policy import load_policy
    policy = load_policy("policy/imitator.safetensors")
    policy.probabilities(observations)  # float32 (N, 6)
    policy.greedy(observations)         # int64 (N,)

    python load_policy.py policy/imitator.safetensors

An observation is uint8 (4, 84, 84): the last four steps' screens, oldest first. A step is four
frames with the same action; its screen is the pixel-wise maximum of its last two frames in
grayscale, averaged over areas to 84x84, with the rows of the score set to 0.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

import numpy as np
import numpy.typing as npt
import torch
from safetensors import safe_open
from torch import Tensor, nn

BATCH_SIZE = 256


class PolicyNetwork(nn.Module):
    """NatureCNN (Mnih et al. 2015) with any number of channels, and the logits of the actions.

    Args:
        channels: Output channels of the three convolutions.
        features: Outputs of the linear layer after them.
        n_actions: Number of actions.
    """

    def __init__(self, channels: list[int], features: int, n_actions: int) -> None:
        super().__init__()
        first, second, third = channels
        self.cnn = nn.Sequential(
            nn.Conv2d(4, first, kernel_size=8, stride=4),
            nn.ReLU(),
            nn.Conv2d(first, second, kernel_size=4, stride=2),
            nn.ReLU(),
            nn.Conv2d(second, third, kernel_size=3, stride=1),
            nn.ReLU(),
            nn.Flatten(),
        )
        self.linear = nn.Sequential(nn.Linear(third * 7 * 7, features), nn.ReLU())
        self.action_net = nn.Linear(features, n_actions)

    def forward(self, observations: Tensor) -> Tensor:
        """Return logits, float32 (N, n_actions), of observations, uint8 (N, 4, 84, 84)."""
        logits: Tensor = self.action_net(self.linear(self.cnn(observations.float() / 255.0)))
        return logits


class Policy:
    """A trained policy.

    Attributes:
        actions: The actions' names, by index.

    Args:
        network: The network.
        actions: The actions' names.
    """

    def __init__(self, network: PolicyNetwork, actions: list[str]) -> None:
        self._network = network.eval()
        self.actions = actions

    def probabilities(self, observations: npt.NDArray[np.uint8]) -> npt.NDArray[np.float32]:
        """Return the probability of each action, float32 (N, n_actions).

        Args:
            observations: uint8 (N, 4, 84, 84), or one observation, uint8 (4, 84, 84).

        Raises:
            ValueError: The observations have another shape or dtype.
        """
        if observations.shape[-3:] != (4, 84, 84) or observations.dtype != np.uint8:
            raise ValueError(
                "Expected observations of shape (N, 4, 84, 84) and dtype uint8, got"
                f" {observations.shape} and {observations.dtype}."
            )
        batch = np.ascontiguousarray(observations).reshape(-1, 4, 84, 84)
        parts = []
        with torch.inference_mode():
            for part in torch.split(torch.from_numpy(batch), BATCH_SIZE):
                parts.append(self._network(part).softmax(1).numpy())
        return np.concatenate(parts)

    def greedy(self, observations: npt.NDArray[np.uint8]) -> npt.NDArray[np.int64]:
        """Return the index of the likeliest action, int64 (N,); raises as ``probabilities``."""
        return np.asarray(self.probabilities(observations).argmax(1), np.int64)


def load_policy(path: str | Path) -> Policy:
    """Load a policy from its file of weights.

    Raises:
        ValueError: The file holds something else.
    """
    with safe_open(str(path), framework="pt") as file:
        metadata = file.metadata() or {}
        if (metadata.get("format"), metadata.get("version")) != ("tril-policy", "1"):
            raise ValueError(f"{path} has no weights of a policy that this program can read.")
        config = json.loads(metadata["config"])
        prefix = "features_extractor."
        # The value network is of use in training only.
        weights = {
            name.removeprefix(prefix): file.get_tensor(name).float()
            for name in file.keys()  # noqa: SIM118
            if not name.startswith("value_net.")
        }
    network = PolicyNetwork(config["channels"], config["features"], len(config["actions"]))
    network.load_state_dict(weights)
    return Policy(network, config["actions"])


if __name__ == "__main__":
    loaded = load_policy(sys.argv[1])
    blank = np.zeros((1, 4, 84, 84), np.uint8)
    for action, probability in zip(loaded.actions, loaded.probabilities(blank)[0], strict=True):
        sys.stdout.write(f"{action:10} {probability:.3f}\n")
