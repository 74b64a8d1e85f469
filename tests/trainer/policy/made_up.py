"""Small pieces of which policy tests are made."""

from dataclasses import replace

import numpy as np
import torch

from trainer.reward.model import RewardModel
from trainer.reward.reward_trainer import new_network
from tril.game.starts import Start
from tril.recipes import FAST, Recipe
from tril.recording import Recording, Trajectory, trajectory

ELSEWHERE = torch.device("meta")
"""PyTorch's device without numbers: it refuses what is not on it, as a GPU does."""

TINY = replace(
    FAST.policy,
    n_envs=4,
    n_steps=8,
    n_minibatches=2,
    n_epochs=2,
    critic_warm_up_steps=32,
    snapshot_steps=(64, 10_000),
    snapshot_episodes=1,
    demonstration_share=0.5,
)


def tiny_recipe(**changes: object) -> Recipe:
    """Return the fast recipe at the smallest size, with some of the policy's values changed."""
    return replace(FAST, policy=replace(TINY, **changes))  # type: ignore[arg-type]


def random_model(zero: float = 0.0, one: float = 1.0) -> RewardModel:
    """Return an untrained reward model."""
    return RewardModel((new_network(np.random.default_rng(4)),), (0.0,), (1.0,), zero, one)


def short_recording(actions: bytes = b"\x01" * 60 + b"\x02" * 60) -> Recording:
    """Return a game of half a second's firing and half a second's walking."""
    return Recording(Start(50), actions)


def short_trajectory() -> Trajectory:
    """Return that game through an agent's eyes."""
    return trajectory(short_recording())


def observations(count: int, seed: int = 0) -> np.ndarray:
    """Return noise, uint8 (count, 4, 84, 84)."""
    return np.random.default_rng(seed).integers(0, 256, (count, 4, 84, 84), dtype=np.uint8)
