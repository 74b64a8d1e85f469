import numpy as np
import pytest
import torch
from torch import Tensor
from torch.nn import functional as F

from trainer.nn.scaling import scale_layers
from trainer.nn.screens import channels_last_screens
from trainer.nn.seeding import torch_seeded
from trainer.policy.cloning import train_clone
from trainer.policy.networks import new_policy
from trainer.progress import NullProgress
from trainer.reward.model import RewardNetwork
from tril.recipes import CloningRecipe
from tril.recording import Trajectory


@pytest.fixture(scope="module")
def screens() -> np.ndarray:
    """A small thing that goes down a bright screen."""
    screens = np.full((64, 4, 84, 84), 140, np.uint8)
    for row, screen in enumerate(screens):
        screen[:, 10 + row : 18 + row, 70:73] = 190
    return screens


def deviation(values: Tensor) -> float:
    """Return how much units differ between screens, on average."""
    return float(values.std(0).mean())


@torch.no_grad()
def test_scaled_layers_of_a_reward_tell_screens_of_a_bright_game_apart(screens: np.ndarray) -> None:
    with torch_seeded(np.random.default_rng(0)):
        network = RewardNetwork(3)

    def hidden() -> Tensor:
        second = network.layers[1](F.leaky_relu(network.first(torch.from_numpy(screens).float())))
        return network.hidden_values(second)

    assert deviation(hidden()) < 0.05
    scale_layers((*network.layers, network.hidden), F.leaky_relu, screens)
    assert deviation(hidden()) > 0.3


@torch.no_grad()
def test_scaled_layers_of_a_policy_tell_screens_of_a_bright_game_apart(screens: np.ndarray) -> None:
    policy = new_policy("small", 6, 1e-3, np.random.default_rng(0))
    observations = channels_last_screens(screens)
    assert deviation(policy.extract_features(observations)) < 0.05
    policy.scale_layers(screens)
    assert deviation(policy.extract_features(observations)) > 0.3


def test_a_clone_of_a_bright_game_learns_sooner_with_scaled_layers(screens: np.ndarray) -> None:
    # What to do hangs on which half the thing is in.
    demonstration = Trajectory(screens, (np.arange(len(screens) - 1) // 32).astype(np.int64))
    recipe = CloningRecipe(network="small", epochs=8, batch_size=16, validation_share=0.0)
    plain, scaled = (
        train_clone(
            [demonstration],
            2,
            recipe if not is_scaled else CloningRecipe(**recipe.__dict__ | {"scale_layers": True}),
            0,
            NullProgress(),
        )[1].accuracy
        for is_scaled in (False, True)
    )
    assert plain < 0.8
    assert scaled > 0.95
