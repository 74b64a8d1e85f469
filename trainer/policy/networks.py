"""Policy networks, and their files: for plain stable-baselines3, and plain weights.

Both sizes are stable-baselines3's NatureCNN (Mnih et al. 2015), the small one with fewer channels.
Training runs them on uint8 input in channels-last order. A saved policy is stable-baselines3's own
ActorCriticCnnPolicy with its own NatureCNN: a small network's channels come first and the others
are zero, which gives the same outputs.
"""

from __future__ import annotations

import io
import json
import zipfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from pickle import UnpicklingError
from typing import Any

import numpy as np
import numpy.typing as npt
import torch
from gymnasium import spaces
from safetensors import SafetensorError
from stable_baselines3 import PPO
from stable_baselines3.common.policies import ActorCriticCnnPolicy
from stable_baselines3.common.torch_layers import BaseFeaturesExtractor
from torch import Tensor, nn
from torch.nn import functional as F

from trainer.nn.checkpoints import check_finite, load_tensors, save_tensors
from trainer.nn.devices import CPU, device_of, forward_batch
from trainer.nn.precision import Precision, layer_dtype
from trainer.nn.scaling import scale_layers
from trainer.nn.screens import channels_last_screens
from trainer.nn.seeding import torch_seeded
from tril.errors import Invalid
from tril.files.artifact_store import write_whole
from tril.play.observation import OBSERVATION_SHAPE, check_observations

OBSERVATION_SPACE = spaces.Box(0, 255, OBSERVATION_SHAPE, np.uint8)


def action_space(n_actions: int) -> spaces.Discrete[np.int64]:
    """Return the space of a game's actions."""
    return spaces.Discrete(n_actions)


@dataclass(frozen=True)
class NetworkSize:
    """Size of a policy's network.

    Attributes:
        channels: Output channels of the three convolutions.
        features: Outputs of the linear layer after them.
    """

    channels: tuple[int, int, int]
    features: int


PRETRAINED = Path(__file__).with_name("pretrained.safetensors")
"""The policy that ships with Tril."""

WEIGHTS_FORMAT = "tril-policy"
WEIGHTS_VERSION = 1

SIZES = {"nature": NetworkSize((32, 64, 64), 512), "small": NetworkSize((16, 32, 32), 256)}


class ScreenFeatures(BaseFeaturesExtractor):
    """NatureCNN of any size, on uint8 input in channels-last order.

    The division by 255 is applied to the first layer's weights, which gives the same sums and saves
    a pass over the input. Parameters have the names that they have in NatureCNN.
    """

    def __init__(self, observation_space: spaces.Box, size: NetworkSize) -> None:
        super().__init__(observation_space, size.features)
        first, second, third = size.channels
        self.cnn = nn.Sequential(
            nn.Conv2d(observation_space.shape[0], first, kernel_size=8, stride=4),
            nn.ReLU(),
            nn.Conv2d(first, second, kernel_size=4, stride=2),
            nn.ReLU(),
            nn.Conv2d(second, third, kernel_size=3, stride=1),
            nn.ReLU(),
            nn.Flatten(),
        )
        self.linear = nn.Sequential(nn.Linear(third * 7 * 7, size.features), nn.ReLU())

    def forward(self, observations: Tensor) -> Tensor:
        """Return features, float32 (N, features), of observations, uint8 (N, 4, 84, 84)."""
        return self.features_of(self.convolve(observations))

    def features_of(self, convolved: Tensor) -> Tensor:
        """Return features, float32 (N, features), of what ``convolve`` has returned."""
        return self.linear(convolved).float()  # type: ignore[no-any-return]

    def convolve(self, observations: Tensor) -> Tensor:
        """Return the convolutions' outputs, (N, channels * 7 * 7), of uint8 (N, 4, 84, 84)."""
        dtype = layer_dtype(observations.device)
        inputs = observations.to(dtype, memory_format=torch.channels_last)
        first = self.cnn[0]
        assert isinstance(first, nn.Conv2d)
        values = F.conv2d(inputs, first.weight / 255.0, first.bias, first.stride)
        return self.cnn[1:](values)  # type: ignore[no-any-return]


class ScreenPolicy(ActorCriticCnnPolicy):
    """stable-baselines3's policy over ScreenFeatures, which take uint8 observations."""

    features_extractor: ScreenFeatures

    def extract_features(  # type: ignore[override]
        self, obs: Tensor, features_extractor: BaseFeaturesExtractor | None = None
    ) -> Tensor:
        """Return features, float32 (N, features), of observations, uint8 (N, 4, 84, 84)."""
        return self.features_extractor(obs)  # type: ignore[no-any-return]

    def logits_and_values(self, observations: Tensor) -> tuple[Tensor, Tensor]:
        """Return logits, float32 (N, n_actions), and values, float32 (N,)."""
        return self.heads(self.extract_features(observations))

    @property
    def n_actions(self) -> int:
        """Number of actions."""
        assert isinstance(self.action_space, spaces.Discrete)
        return int(self.action_space.n)

    def scale_layers(self, observations: npt.NDArray[np.uint8]) -> None:
        """Scale the layers below the heads on observations, uint8 (N, 4, 84, 84)."""
        extractor = self.features_extractor
        kinds = (nn.Conv2d, nn.Linear)
        layers = [layer for layer in extractor.modules() if isinstance(layer, kinds)]
        scale_layers(layers, F.relu, observations)

    def freeze_convolutions(self) -> None:
        """Let only the layers above the convolutions learn."""
        self.features_extractor.cnn.requires_grad_(False)

    def heads(self, features: Tensor) -> tuple[Tensor, Tensor]:
        """Return logits, float32 (N, n_actions), and values, float32 (N,), of features."""
        with Precision.FLOAT32.autocast(features.device):
            return self.action_net(features), self.value_net(features).squeeze(1)


def policy_arguments(network: str) -> dict[str, Any]:
    """Return the ``policy_kwargs`` of PPO for a ScreenPolicy of this size."""
    return {
        "net_arch": [],
        "features_extractor_class": ScreenFeatures,
        "features_extractor_kwargs": {"size": SIZES[network]},
        "normalize_images": False,
        # eps is stable-baselines3's; the fused step computes the same faster.
        "optimizer_kwargs": {"eps": 1e-5, "fused": True},
    }


def new_policy(
    network: str,
    n_actions: int,
    learning_rate: float,
    rng: np.random.Generator,
    device: torch.device = CPU,
) -> ScreenPolicy:
    """Return a policy with stable-baselines3's orthogonal initialisation, drawn from ``rng``."""
    with torch_seeded(rng):
        policy = _screen_policy(policy_arguments(network), n_actions, learning_rate)
    return channels_last(policy.to(device))


def pretrained_policy(learning_rate: float, device: torch.device = CPU) -> ScreenPolicy:
    """Return the policy of size "small" that ships with Tril; see scripts.pretraining."""
    tensors, _ = load_tensors(PRETRAINED)
    policy = _screen_policy(policy_arguments("small"), _n_actions(tensors), learning_rate)
    _load_shared(policy, tensors)
    return channels_last(policy.to(device))


def _shared(name: str) -> str:
    """Return the one name of a weight that actor and critic share under two more."""
    return name.removeprefix("pi_").removeprefix("vf_")


def shared_weights(policy: ScreenPolicy) -> dict[str, Tensor]:
    """Return a policy's weights, those that actor and critic share once."""
    return {_shared(name): one for name, one in policy.state_dict().items()}


def _load_shared(policy: ScreenPolicy, weights: Mapping[str, Tensor]) -> None:
    policy.load_state_dict({n: weights[_shared(n)].float() for n in policy.state_dict()})


def _screen_policy(
    arguments: dict[str, Any], n_actions: int, learning_rate: float = 0.0
) -> ScreenPolicy:
    actions = action_space(n_actions)
    return ScreenPolicy(OBSERVATION_SPACE, actions, lambda _: learning_rate, **arguments)


def channels_last(policy: ScreenPolicy) -> ScreenPolicy:
    """Put the convolutions' weights into channels-last order, in place."""
    policy.to(memory_format=torch.channels_last)  # type: ignore[call-overload]
    return policy


class Policy:
    """A trained policy for inference.

    Args:
        network: The policy's network.
    """

    def __init__(self, network: ScreenPolicy) -> None:
        self._network = network

    def logits(self, pixels: Tensor) -> Tensor:
        """Return the logit of each action, float32 (N, 6), differentiable.

        Args:
            pixels: uint8 or float32 (N, 4, 84, 84), 0 to 255.
        """
        return self._network.logits_and_values(pixels)[0]

    def probabilities(self, observations: npt.NDArray[np.uint8]) -> npt.NDArray[np.float32]:
        """Return the probability of each action, float32 (N, 6).

        Args:
            observations: uint8 (N, 4, 84, 84).

        Raises:
            ValueError: The observations have another shape or dtype.
        """
        check_observations(observations)
        result = np.empty((len(observations), self._network.n_actions), np.float32)
        device = device_of(self._network)
        size = forward_batch(device)
        with torch.inference_mode():
            for begin in range(0, len(observations), size):
                part = slice(begin, begin + size)
                batch = channels_last_screens(observations[part]).to(device)
                logits, _ = self._network.logits_and_values(batch)
                result[part] = logits.softmax(1).cpu().numpy()
        return result


def save_policy(policy: ScreenPolicy, path: Path) -> None:
    """Save a policy as a .zip that plain ``PPO.load`` loads without this project.

    Args:
        policy: The policy; its optimizer is not saved.
        path: The file, replaced as a whole.
    """
    check_finite("policy", *policy.parameters())
    features = policy.features_extractor.features_dim
    plain = PPO(
        ActorCriticCnnPolicy,
        env=None,  # type: ignore[arg-type]
        device="cpu",
        n_steps=1,
        policy_kwargs={"features_extractor_kwargs": {"features_dim": features}},
        _init_setup_model=False,
    )
    plain.observation_space = OBSERVATION_SPACE
    plain.action_space = action_space(policy.n_actions)
    plain.n_envs = 1
    with torch.random.fork_rng(devices=[]):
        plain._setup_model()
    larger = plain.policy.state_dict()
    for name, tensor in policy.state_dict().items():
        larger[name] = torch.zeros_like(larger[name])
        larger[name][tuple(slice(length) for length in tensor.shape)] = tensor
    plain.policy.load_state_dict(larger)
    content = io.BytesIO()
    plain.save(content)
    write_whole(path, content.getvalue())


def save_weights(
    policy: ScreenPolicy, path: Path, actions: Sequence[str], *, half: bool = False
) -> None:
    """Save a policy's weights as safetensors, with what it takes to rebuild its network.

    Args:
        policy: The policy.
        path: The file, replaced as a whole.
        actions: Names of the game's actions.
        half: Whether the weights are rounded to half precision; otherwise they are float32.
    """
    layers = [one for one in policy.features_extractor.modules() if isinstance(one, nn.Conv2d)]
    config = {
        "channels": [layer.out_channels for layer in layers],
        "features": policy.features_extractor.features_dim,
        "observation_shape": OBSERVATION_SHAPE,
        "actions": list(actions),
    }
    weights = shared_weights(policy)
    save_tensors(
        path,
        {name: one.half() if half else one.float() for name, one in weights.items()},
        {
            "format": WEIGHTS_FORMAT,
            "version": str(WEIGHTS_VERSION),
            "config": json.dumps(config),
        },
    )


def load_policy(path: Path) -> Policy:
    """Load a policy that was saved in either format, for inference; raises as ``load_network``."""
    return Policy(load_network(path))


def load_network(path: Path) -> ScreenPolicy:
    """Load the network of a policy that was saved, without executing pickles.

    Args:
        path: What ``save_weights`` wrote if it ends with .safetensors, else what ``save_policy``
            did.

    Raises:
        Invalid: The file is no such policy.
    """
    if path.suffix == ".safetensors":
        return _network_of_weights(path)
    try:
        with zipfile.ZipFile(path) as archive:
            weights = io.BytesIO(archive.read("policy.pth"))
        larger: dict[str, Tensor] = torch.load(weights, map_location="cpu", weights_only=True)
        network = _network_of(larger)
        own = network.state_dict()
        network.load_state_dict(
            {
                name: larger[name][tuple(slice(length) for length in tensor.shape)]
                for name, tensor in own.items()
            }
        )
    except (zipfile.BadZipFile, KeyError, RuntimeError, UnpicklingError, IndexError) as error:
        raise Invalid(f"{path.name} cannot be read as a policy: {error}") from error
    network.set_training_mode(False)
    return network


def _network_of_weights(path: Path) -> ScreenPolicy:
    try:
        weights, metadata = load_tensors(path)
        kind = (metadata.get("format"), metadata.get("version"))
        if kind != (WEIGHTS_FORMAT, str(WEIGHTS_VERSION)):
            raise Invalid(f"{path.name} has no weights of a policy that this version can read.")
        config = json.loads(metadata["config"])
        size = NetworkSize(tuple(config["channels"]), config["features"])
        if size not in SIZES.values():
            raise Invalid(f"{path.name} is of a network of an unknown size.")
        network = _sized(size, _n_actions(weights))
        if extra := weights.keys() - shared_weights(network).keys():
            raise Invalid(f"{path.name} has unknown weights: {', '.join(sorted(extra)[:4])}.")
        _load_shared(network, weights)
    except (SafetensorError, json.JSONDecodeError, KeyError, TypeError, RuntimeError) as error:
        raise Invalid(f"{path.name} cannot be read as a policy: {error}") from error
    network.set_training_mode(False)
    return network


def _n_actions(weights: Mapping[str, Tensor]) -> int:
    return len(weights["action_net.weight"])


def _sized(size: NetworkSize, n_actions: int) -> ScreenPolicy:
    arguments = policy_arguments("nature")
    arguments["features_extractor_kwargs"] = {"size": size}
    # Its weights are replaced; to make them orthogonal would take most of the time of loading.
    arguments["ortho_init"] = False
    with torch.random.fork_rng(devices=[]):
        return channels_last(_screen_policy(arguments, n_actions))


def _network_of(weights: dict[str, Tensor]) -> ScreenPolicy:
    """Return a network of the smallest size that holds all weights other than zero."""
    features = weights["features_extractor.linear.0.weight"].shape[0]
    for size in sorted(SIZES.values(), key=lambda one: one.channels):
        rest = [
            weights[f"features_extractor.cnn.{layer}.weight"][channels:]
            for layer, channels in zip((0, 2, 4), size.channels, strict=True)
        ]
        if size.features == features and not any(part.any() for part in rest):
            return _sized(size, _n_actions(weights))
    raise Invalid("The policy's network has an unknown size.")
