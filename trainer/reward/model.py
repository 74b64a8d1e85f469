"""The reward model R(observation): the published network, or one with pretrained layers."""

from __future__ import annotations

import json
from collections.abc import Mapping
from copy import deepcopy
from dataclasses import dataclass, replace
from enum import StrEnum
from pathlib import Path

import numpy as np
import numpy.typing as npt
import torch
from safetensors import SafetensorError
from torch import Tensor, nn
from torch.nn import functional as F

from trainer.nn.checkpoints import load_tensors, prefixed, save_tensors, split_by_prefix
from trainer.nn.devices import device_of, forward_batch
from trainer.nn.screens import channels_last_screens
from trainer.nn.seeding import torch_seeded
from tril.errors import Invalid
from tril.games.space_invaders.memory import COLUMNS, ROWS
from tril.play.observation import check_observations

FORMAT = "tril-reward-model"
FORMAT_VERSION = 1
N_ORDER = ROWS * (COLUMNS - 1)
"""How many values of the order of hits R is linear in, see Order."""
_NETWORK = "0"
_SPREAD = "spread"
"""Prefix of the tensors of a Spread in a file."""


class Order(StrEnum):
    """What of the order of hits R is linear in, besides which aliens are left."""

    NONE = ""
    GAPS = "gaps"
    SWEEPS = "sweeps"


class RewardNetwork(nn.Module):
    """The reward network of the thesis (appendix A): four convolutions and two linear layers.

    The thesis names no activation; leaky ReLU after every layer but the last and the division of
    inputs by 255 are T-REX's (Brown et al. 2019, published code). The division is applied to the
    first layer's weights, which gives the same sums and saves a pass over the inputs.

    A pretrained network has one more layer below the output, which reads off the screen which
    aliens are left; R is linear in their probabilities and in how far each row has been swept. See
    trainer.reward.pretraining. In networks of earlier versions R is linear in the probabilities
    alone, of aliens or of bits of the console's memory, or in gaps between the aliens, too.

    Args:
        n_flags: Size of that layer; 0 leaves it out.
        order: Further inputs of R, for flags of the 36 aliens.
    """

    def __init__(self, n_flags: int = 0, order: Order = Order.NONE) -> None:
        super().__init__()
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
        self.order = order
        self.output = nn.Linear(n_flags + N_ORDER * bool(order) if n_flags else 64, 1)
        self.to(memory_format=torch.channels_last)  # type: ignore[call-overload]

    @property
    def layers(self) -> tuple[nn.Conv2d, ...]:
        """The convolutions, first to last."""
        return tuple(layer for layer in self.convolutions if isinstance(layer, nn.Conv2d))

    def forward(self, observations: Tensor) -> Tensor:
        """Return R, float32 (N,), of observations, uint8 (N, 4, 84, 84)."""
        return self.from_features(self.read(observations))

    def read(self, observations: Tensor) -> Tensor:
        """Return the inputs of R, see ``features``, of observations, uint8 (N, 4, 84, 84)."""
        inputs = observations.to(torch.float32, memory_format=torch.channels_last)
        return self.features(self.layers[1](F.leaky_relu(self.first(inputs))))

    def from_features(self, features: Tensor) -> Tensor:
        """Return R, float32 (N,), from what it is linear in."""
        return self.output(features).squeeze(1)  # type: ignore[no-any-return]

    def first(self, inputs: Tensor) -> Tensor:
        """Return the first layer before its activation, float32 (N, 16, 26, 26).

        Args:
            inputs: float32 (N, 4, 84, 84), 0 to 255.
        """
        layer = self.layers[0]
        return F.conv2d(inputs, layer.weight / 255.0, layer.bias, layer.stride)

    def after_first(self, first: Tensor) -> Tensor:
        """Return R, float32 (N,), from the output of ``first``."""
        return self.after_second(self.layers[1](F.leaky_relu(first)))

    def after_second(self, second: Tensor) -> Tensor:
        """Return R, float32 (N,), from the second layer before its activation."""
        return self.from_features(self.features(second))

    def features(self, second: Tensor) -> Tensor:
        """Return the inputs of R, from the second layer before its activation.

        Returns:
            float32 (N, 64); of a pretrained network (N, n_flags) or (N, n_flags + 30), all from 0
            to 1.
        """
        values = self.hidden_values(second)
        if self.memory is None:
            return values
        flags: Tensor = self.memory(values).sigmoid()
        if not self.order:
            return flags
        of_order = swept_to(flags) if self.order is Order.SWEEPS else gaps_between(flags)
        return torch.cat([flags, of_order], 1)

    def hidden_values(self, second: Tensor) -> Tensor:
        """Return the hidden layer's values, float32 (N, 64), from the same."""
        values = F.leaky_relu(second)
        for layer in self.layers[2:]:
            values = F.leaky_relu(layer(values))
        return F.leaky_relu(self.hidden(values.flatten(1)))


def swept_to(aliens: Tensor) -> Tensor:
    """Return the degree to which each row is swept from its left end on, float32 (N, 30), 0 to 1.

    Of each row, the probabilities that its first two, three, … six aliens are all gone. What single
    aliens add to R cannot say in which order they are hit, as each is gone in the end.

    Args:
        aliens: float32 (N, 36), the probability that each is left, row by row.
    """
    cleared = 1.0 - aliens.reshape(-1, ROWS, COLUMNS)
    swept: Tensor = cleared.cumprod(2)[:, :, 1:]
    return swept.flatten(1)


def gaps_between(aliens: Tensor) -> Tensor:
    """Return the gaps: an alien without a right neighbour, float32 (N, 30), 0 to 0.5.

    Networks were saved with these before sweeps; the arguments are the same. See
    docs/decisions/07-order.md.
    """
    grid = aliens.reshape(-1, ROWS, COLUMNS)
    gaps: Tensor = 0.5 * grid[:, :, :-1] * (1.0 - grid[:, :, 1:])
    return gaps.flatten(1)


def new_network(rng: np.random.Generator) -> RewardNetwork:
    """Return a network with PyTorch's default initialisation, drawn from ``rng``."""
    with torch_seeded(rng):
        return RewardNetwork()


def network_of(weights: Mapping[str, Tensor], order: Order) -> RewardNetwork:
    """Return a network with these weights, pretrained if they are.

    Args:
        weights: Tensors by name.
        order: Order of hits in which R is linear, if its output is wide enough.

    Raises:
        RuntimeError: They are not a reward network's.
    """
    n_flags = len(weights.get("memory.bias", ()))
    n_features = weights["output.weight"].shape[1]
    network = RewardNetwork(n_flags, order if n_features == n_flags + N_ORDER else Order.NONE)
    network.load_state_dict(weights)
    return network


@dataclass(frozen=True)
class Spread:
    """How sure a pretrained network's R is: its standard deviation at an observation.

    R is linear in the network's features, and so is the deviation of each refit of its output from
    their mean. The standard deviation is the norm of these deviations, each scaled as the estimator
    says that made them, see trainer.reward.check.

    Attributes:
        weight: float32 (K, n_features).
        bias: float32 (K,).
    """

    weight: Tensor
    bias: Tensor

    def __post_init__(self) -> None:
        """Check shapes and values; raises ValueError."""
        if self.weight.ndim != 2 or self.bias.shape != self.weight.shape[:1]:
            raise ValueError(
                f"Expected a row of weights per bias, got {tuple(self.weight.shape)} and"
                f" {tuple(self.bias.shape)}."
            )
        if not (self.weight.isfinite().all() and self.bias.isfinite().all()):
            raise ValueError("Expected a finite spread.")

    def at(self, features: Tensor) -> Tensor:
        """Return the standard deviation of R, float32 (N,), from features (N, n_features)."""
        deviations = F.linear(features, self.weight.to(features), self.bias.to(features))
        norms: Tensor = torch.linalg.vector_norm(deviations, dim=1)
        return norms


@dataclass(frozen=True)
class JudgedObservations:
    """R of observations, and how sure the model is.

    Attributes:
        rewards: R, float32 (N,).
        deviations: The standard deviation of R, float32 (N,), non-negative; None if the model does
            not know it.
    """

    rewards: npt.NDArray[np.float32]
    deviations: npt.NDArray[np.float32] | None


@dataclass(frozen=True)
class RewardModel:
    """R(observation), a network's ``(output - offset) / scale``.

    Attributes:
        network: The network.
        offset: Subtracted from its output.
        scale: Divisor of the difference, positive.
        zero: R at which the level is 0, see ``level``.
        one: R at which the level is 1.
        spread: Uncertainty of a pretrained network; None where nobody measured it.
    """

    network: RewardNetwork
    offset: float = 0.0
    scale: float = 1.0
    zero: float = 0.0
    one: float = 1.0
    spread: Spread | None = None

    def __post_init__(self) -> None:
        """Freeze the network.

        Raises:
            ValueError: Offset, scale or levels are not finite, or not in order.
        """
        if not np.isfinite(self.offset) or not 0 < self.scale < np.inf:
            raise ValueError(f"Offset or scale is unusable: {self.offset}, {self.scale}.")
        if not (np.isfinite(self.zero) and np.isfinite(self.one) and self.zero < self.one):
            raise ValueError(f"Expected a level from low to high, got {self.zero} to {self.one}.")
        n_features = self.network.output.in_features
        if self.spread is not None and self.spread.weight.shape[1] != n_features:
            raise ValueError("Expected a spread of the network's features.")
        self.network.requires_grad_(False)

    def score(self, observations: npt.NDArray[np.uint8]) -> npt.NDArray[np.float32]:
        """Return R, float32 (N,), of observations, uint8 (N, 4, 84, 84).

        Raises:
            ValueError: The observations have another shape or dtype.
        """
        rewards: npt.NDArray[np.float32] = self._evaluate(observations, with_deviations=False)[0]
        return rewards

    def judge(self, observations: npt.NDArray[np.uint8]) -> JudgedObservations:
        """Return R of observations, uint8 (N, 4, 84, 84), and how sure the model is by ``spread``.

        Raises:
            ValueError: The observations have another shape or dtype.
        """
        if self.spread is None:
            return JudgedObservations(self.score(observations), None)
        return JudgedObservations(*self._evaluate(observations, with_deviations=True))

    def _evaluate(
        self, observations: npt.NDArray[np.uint8], *, with_deviations: bool
    ) -> npt.NDArray[np.float32]:
        """Return R, and, if asked for, its standard deviations: float32 (1 or 2, N)."""
        check_observations(observations)
        result = np.empty((1 + with_deviations, len(observations)), np.float32)
        device = device_of(self.network)
        size = forward_batch(device)
        with torch.inference_mode():
            for begin in range(0, len(observations), size):
                part = slice(begin, begin + size)
                batch = channels_last_screens(observations[part]).to(device)
                features = self.network.read(batch)
                rows = [self.of_output(self.network.from_features(features))]
                if with_deviations:
                    assert self.spread is not None
                    rows.append(self.spread.at(features))
                result[:, part] = torch.stack(rows).cpu().numpy()
        return result

    def score_features(self, features: Tensor) -> npt.NDArray[np.float32]:
        """Return R, float32 (N,), from what a pretrained network reads, see RewardNetwork.read."""
        with torch.inference_mode():
            inputs = features.to(device_of(self.network))
            return self.of_output(self.network.from_features(inputs)).cpu().numpy()

    def of_pixels(self, pixels: Tensor) -> Tensor:
        """Return R, float32 (N,), differentiable, of float32 (N, 4, 84, 84), 0 to 255."""
        return self.of_output(self.network.after_first(self.network.first(pixels)))

    def of_output(self, output: Tensor) -> Tensor:
        """Return R from the network's output, tensors of the same shape."""
        return (output - self.offset) / self.scale

    def level(self, rewards: npt.NDArray[np.float32]) -> npt.NDArray[np.float32]:
        """Return R scaled so that ``zero`` becomes 0 and ``one`` becomes 1, float32."""
        return ((rewards - self.zero) / (self.one - self.zero)).astype(np.float32)

    def total_level(self, predicted_return: float, n_steps: int) -> float:
        """Return the sum of the levels of states, from the sum of their R.

        Args:
            predicted_return: Sum of R over the states.
            n_steps: Number of the states.
        """
        return (predicted_return - n_steps * self.zero) / (self.one - self.zero)

    def on(self, device: torch.device) -> RewardModel:
        """Return the model on a device: itself if it is there already, else a copy."""
        if device_of(self.network) == device:
            return self
        return replace(self, network=deepcopy(self.network).to(device))

    def save(self, path: Path) -> None:
        """Write the model as safetensors; everything but the weights is JSON in the header."""
        tensors = prefixed(_NETWORK, self.network.state_dict(), ".")
        if self.spread is not None:
            # Versions that do not know it read the network alone.
            tensors_of_spread = {"weight": self.spread.weight, "bias": self.spread.bias}
            tensors |= prefixed(_SPREAD, tensors_of_spread, ".")
        header = {
            "offsets": [self.offset],
            "scales": [self.scale],
            "zero": self.zero,
            "one": self.one,
            "order": self.network.order,
        }
        metadata = {
            "format": FORMAT,
            "version": str(FORMAT_VERSION),
            "model": json.dumps(header, allow_nan=False),
        }
        save_tensors(path, tensors, metadata)

    @classmethod
    def load(cls, path: Path) -> RewardModel:
        """Read a model that ``save`` wrote.

        Raises:
            Invalid: The file is no reward model, or has another format version.
        """
        try:
            tensors, metadata = load_tensors(path)
            if metadata.get("format") != FORMAT:
                raise Invalid(f"{path.name} is not a reward model of Tril.")
            if metadata.get("version") != str(FORMAT_VERSION):
                raise Invalid(
                    f"{path.name} is a reward model of format {metadata.get('version')}; this"
                    f" version of Tril reads format {FORMAT_VERSION}."
                )
            header = json.loads(metadata["model"])
            weights = split_by_prefix(tensors, ".")
            if (n_networks := len(header["offsets"])) != 1:
                raise Invalid(
                    f"{path.name} is an ensemble of {n_networks} networks, which this version of"
                    " Tril no longer reads."
                )
            (offset,), (scale,) = header["offsets"], header["scales"]
            # Files from before sweeps do not say it.
            order = Order(header.get("order", Order.GAPS))
            return cls(
                network_of(weights[_NETWORK], order),
                offset,
                scale,
                header["zero"],
                header["one"],
                _spread_of(weights[_SPREAD]) if _SPREAD in weights else None,
            )
        except (SafetensorError, KeyError, RuntimeError, TypeError, ValueError) as error:
            raise Invalid(f"{path.name} cannot be read as a reward model: {error}") from error


def _spread_of(tensors: Mapping[str, Tensor]) -> Spread:
    return Spread(tensors["weight"].float(), tensors["bias"].float())


def predicted_return(model: RewardModel, observations: npt.NDArray[np.uint8]) -> float:
    """Return the sum of R over the states of a trajectory (thesis, section 5.1).

    Args:
        model: The reward model.
        observations: uint8 (T + 1, 4, 84, 84): the start and the state after each of T steps. The
            start does not count: no action reached it, and all games share it.
    """
    return float(model.score(observations[1:]).sum(dtype=np.float64))
