"""Small recipes, models, games and trainings that the tests of learning share."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch

from trainer.policy.imitation import ImitationTask, ImitatorResult
from trainer.policy.networks import new_policy, save_policy
from trainer.progress import Progress, RunCancelled
from trainer.reward.model import RewardModel, new_network
from tril.games.atari.starts import AtariStart
from tril.games.space_invaders import SPACE_INVADERS
from tril.games.space_invaders.behaviours import BUILT_IN
from tril.recipes import FAST, PAPER, Recipe
from tril.recording import Recording, Trajectory

ELSEWHERE = torch.device("meta")
"""PyTorch's device without data: it refuses tensors of other devices, as a GPU does."""

STEPS = 128
"""Of the imitators' trainings."""

TINY = replace(
    FAST.policy,
    death_forfeit=0.0,
    opening_share=0.0,
    sticky_action_probability=0.0,
    freeze_convolutions=False,
    n_envs=4,
    n_steps=8,
    n_minibatches=2,
    n_epochs=2,
    critic_warm_up_steps=32,
    snapshot_steps=(64, 10_000),
    snapshot_episodes=1,
    demonstration_share=0.5,
)

REWARD_RECIPE = replace(
    PAPER.reward,
    updates=120,
    fold_updates=60,
    fragment_pairs=50,
    learning_rate=5e-4,
    fragment_min_steps=10,
    fragment_max_steps=20,
)

TIERS = [[0], [1], [2, 3], [4], [5]]
"""Of planted_trajectories."""


def tiny_recipe(**changes: object) -> Recipe:
    """Return the fast recipe at the smallest size, with some of the policy's values changed."""
    return replace(FAST, policy=replace(TINY, **changes))  # type: ignore[arg-type]


def random_model(zero: float = 0.0, one: float = 1.0) -> RewardModel:
    """Return an untrained reward model."""
    return RewardModel(new_network(np.random.default_rng(4)), zero=zero, one=one)


def short_recording(actions: bytes = b"\x01" * 60 + b"\x02" * 60) -> Recording:
    """Return a game of one second of firing and one of walking."""
    return Recording(SPACE_INVADERS, AtariStart(50), actions)


def observations(count: int, seed: int = 0) -> np.ndarray:
    """Return noise, uint8 (count, 4, 84, 84)."""
    return np.random.default_rng(seed).integers(0, 256, (count, 4, 84, 84), dtype=np.uint8)


def planted_trajectory(rng: np.random.Generator, quality: int, n_steps: int) -> Trajectory:
    """Return a noisy trajectory whose lower half grows brighter, the faster the better it is.

    Args:
        rng: Source of the noise.
        quality: 0 stays dark; 5 brightens most.
        n_steps: Its length.
    """
    screens = rng.integers(0, 60, (n_steps + 1, 4, 84, 84), dtype=np.uint8)
    brightness = np.linspace(0, 30 * quality, n_steps + 1).astype(np.uint8)
    screens[:, :, 42:, :] += brightness[:, None, None, None]
    return Trajectory(screens, rng.integers(0, 6, n_steps))


def planted_trajectories(n_steps: int = 40) -> list[Trajectory]:
    """Return six trajectories, the best first; one of them is half as long as the others."""
    rng = np.random.default_rng(3)
    return [
        planted_trajectory(rng, quality, n_steps // 2 if quality == 2 else n_steps)
        for quality in (5, 4, 3, 2, 1, 0)
    ]


def imitation_task(folder: Path) -> ImitationTask:
    """Return a task of two ranked games and a perfect one, with a clone saved in the folder."""
    clone = folder / "clone.zip"
    save_policy(new_policy("small", 6, 1e-3, np.random.default_rng(8)), clone)
    return ImitationTask(
        game=SPACE_INVADERS,
        model=random_model(),
        recordings=[short_recording(), short_recording(b"\x00" * 80)],
        tiers=[[0], [1]],
        recipe=tiny_recipe(),
        steps=STEPS,
        training_seed=11,
        behaviour=BUILT_IN[0],
        perfect=[short_recording()],
        start_policy=clone,
    )


class RecordingProgress:
    """Keeps what is reported, and cancels at one of the reports."""

    def __init__(self, cancel_at: int | None = None) -> None:
        self.done: list[int] = []
        self.totals: set[int] = set()
        self.points: list[tuple[int, dict[str, float]]] = []
        self._cancel_at = cancel_at

    def advance(self, done: int, total: int, values: Mapping[str, float] | None = None) -> None:
        self.done.append(done)
        self.totals.add(total)
        if values:
            self.points.append((done, dict(values)))
        if len(self.done) == self._cancel_at:
            raise RunCancelled

    @property
    def curves(self) -> list[tuple[int, dict[str, float]]]:
        """The points without the speed, which differs from run to run."""
        return [
            (done, {name: v for name, v in values.items() if name != "steps_per_s"})
            for done, values in self.points
        ]


Train = Callable[[ImitationTask, Path, Path, Progress], ImitatorResult]


class FinishedTraining:
    """An imitator's training from beginning to end, in a folder of its own."""

    def __init__(self, train: Train, task: ImitationTask, folder: Path) -> None:
        folder.mkdir()
        self.train = train
        self.task = task
        self.folder = folder
        self.path = folder / "imitator.zip"
        self.progress = RecordingProgress()
        self.result = train(task, self.path, folder, self.progress)
        self.weights = weights(self.path)

    def check_interrupted(self, folder: Path, cancel_at: int) -> RecordingProgress:
        """Train again in an empty folder, interrupted at a report; return what was reported then.

        Result, weights and curves have to be those of the uninterrupted training.
        """
        path = folder / "imitator.zip"
        interrupted, resumed = RecordingProgress(cancel_at), RecordingProgress()
        with pytest.raises(RunCancelled):
            self.train(self.task, path, folder, interrupted)
        assert not path.exists()
        assert self.train(self.task, path, folder, resumed) == self.result
        assert same(weights(path), self.weights)
        # The curves continue where the checkpoint was, without a gap or a jump.
        begun = resumed.done[0]
        assert begun <= interrupted.done[-1]
        kept = [point for point in interrupted.curves if point[0] <= begun]
        assert kept + resumed.curves == self.progress.curves
        return interrupted


def weights(path: Path) -> dict[str, torch.Tensor]:
    """Return the weights in a policy's file."""
    with zipfile.ZipFile(path) as archive:
        loaded: dict[str, torch.Tensor] = torch.load(
            io.BytesIO(archive.read("policy.pth")), weights_only=True
        )
        return loaded


def same(one: Mapping[str, torch.Tensor], other: Mapping[str, torch.Tensor]) -> bool:
    """Return whether weights are equal, bit by bit."""
    return all(torch.equal(tensor, other[name]) for name, tensor in one.items())
