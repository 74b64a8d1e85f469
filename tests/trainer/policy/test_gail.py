"""GAIL: the discriminator, the reward that follows it, and the training as a whole."""

from __future__ import annotations

from copy import deepcopy
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch

from tests.trainer.samples import (
    STEPS,
    FinishedTraining,
    RecordingProgress,
    imitation_task,
    observations,
    random_model,
    same,
    short_recording,
    tiny_recipe,
    weights,
)
from trainer.policy import imitator
from trainer.policy.discriminator import Discriminator
from trainer.policy.evaluation import play
from trainer.policy.imitation import ImitationTask
from trainer.policy.imitator import train_imitator
from trainer.policy.reward_shaping import RewardShaping
from trainer.reward.model import RewardModel
from tril.demonstrators import Demonstration, ExampleKind, example_tasks, execute
from tril.errors import Invalid
from tril.games.atari.starts import AtariStart
from tril.games.space_invaders import SPACE_INVADERS
from tril.games.space_invaders.behaviours import BUILT_IN
from tril.recipes import GailRecipe
from tril.recording import Trajectory, trajectory

QUICK = GailRecipe(learning_rate=1e-3, updates=40)


def acted_in(*trajectories: Trajectory) -> torch.Tensor:
    return torch.from_numpy(np.concatenate([one.observations[:-1] for one in trajectories]))


class Random:
    """A policy that does anything."""

    def probabilities(self, seen: np.ndarray) -> np.ndarray:
        return np.full((len(seen), 6), 1 / 6, np.float32)


@pytest.fixture(scope="module")
def shown() -> list[Demonstration]:
    """Return two perfect games of column 1."""
    kind = ExampleKind("perfect", "perfect games alone", n_ranked=0)
    return list(execute(example_tasks(BUILT_IN[0], np.random.default_rng(1), 2, kind)))


@pytest.fixture(scope="module")
def random_games() -> list[Trajectory]:
    starts = [AtariStart(idle) for idle in range(0, 120, 10)]
    games = play(SPACE_INVADERS, Random(), starts, "sampled", n_processes=1)
    return [trajectory(game.recording) for game in games]


def test_the_discriminator_tells_the_expert_from_a_random_policy_and_the_reward_follows(
    shown: list[Demonstration], random_games: list[Trajectory]
) -> None:
    learned_from, held_out = (trajectory(one.recording) for one in shown)
    discriminator = Discriminator(acted_in(learned_from), QUICK, 0)
    first = discriminator.learn(acted_in(*random_games[:-3]), lambda: None)
    for _ in range(3):
        last = discriminator.learn(acted_in(*random_games[:-3]), lambda: None)
    assert first["discriminator_accuracy"] < last["discriminator_accuracy"]
    assert last["discriminator_accuracy"] > 0.9
    assert last["discriminator_loss"] < first["discriminator_loss"]
    # On games of both that it has not seen.
    shaping = RewardShaping(discriminator.model, "softplus", 0.0)
    expert = discriminator.model.score(held_out.observations[1:])
    unseen = np.concatenate([one.observations[1:] for one in random_games[-3:]])
    random = discriminator.model.score(unseen)
    assert (expert > 0).mean() > 0.6
    assert (random < 0).mean() > 0.6
    nobody = np.zeros(1, np.bool_)
    means = [shaping.shape(one, one, nobody).mean() for one in (expert, random)]
    assert means[0] > 1.5 * means[1] > 0
    np.testing.assert_allclose(
        shaping.shape(expert, expert, nobody), -np.log1p(-1 / (1 + np.exp(-expert))), rtol=1e-3
    )


def test_the_reward_changes_only_between_rounds() -> None:
    noise = torch.from_numpy(observations(32))
    discriminator = Discriminator(noise, replace(QUICK, updates=2), 0)
    seen = observations(8, 1)
    before = discriminator.model.score(seen)
    during: list[np.ndarray] = []
    discriminator.learn(noise, lambda: during.append(discriminator.model.score(seen)))
    assert len(during) == 2
    assert all(np.array_equal(before, scores) for scores in during)
    assert not np.array_equal(before, discriminator.model.score(seen))


def test_a_discriminator_goes_on_from_its_tensors_as_if_nothing_had_been() -> None:
    shown, played = torch.from_numpy(observations(64)), torch.from_numpy(observations(64, 1))
    recipe = replace(QUICK, updates=3)
    whole = Discriminator(shown, recipe, 7)
    whole.learn(played, lambda: None)
    kept = {name: tensor.clone() for name, tensor in whole.tensors().items()}
    again = Discriminator(shown, recipe, 7)
    again.restore(whole.rounds, kept)
    assert again.learn(played, lambda: None) == whole.learn(played, lambda: None)
    seen = observations(8, 2)
    np.testing.assert_array_equal(again.model.score(seen), whole.model.score(seen))
    other = Discriminator(shown, recipe, 8)
    assert not np.array_equal(other.model.score(seen), whole.model.score(seen))


@pytest.fixture(scope="module")
def task(tmp_path_factory: pytest.TempPathFactory) -> ImitationTask:
    recipe = tiny_recipe(reward="softplus", snapshot_steps=())
    recipe = replace(recipe, method="gail", gail=GailRecipe(updates=2, batch_size=16))
    return replace(imitation_task(tmp_path_factory.mktemp("clone")), recipe=recipe)


@pytest.fixture(scope="module")
def finished(task: ImitationTask, tmp_path_factory: pytest.TempPathFactory) -> FinishedTraining:
    return FinishedTraining(train_imitator, task, tmp_path_factory.mktemp("gail") / "whole")


def test_the_last_policy_is_kept_and_the_curves_show_the_discriminator(
    finished: FinishedTraining,
) -> None:
    assert finished.result.best_steps == STEPS
    assert len(finished.result.snapshots) == 1
    points = finished.progress.points
    assert [done for done, _ in points] == [32, 64, 96, 128]
    always = {"discriminator_loss", "discriminator_accuracy", "value_loss", "steps_per_s"}
    assert all(always <= set(values) for _, values in points)
    # What it is paid is no prediction of the learned reward.
    assert not any("predicted_return" in values for _, values in points)


@pytest.mark.parametrize("cancel_at", [45, 62])
def test_an_interrupted_training_ends_with_the_same_weights(
    finished: FinishedTraining, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, cancel_at: int
) -> None:
    monkeypatch.setattr(imitator, "CHECKPOINT_INTERVAL_S", 0.0)
    assert finished.check_interrupted(tmp_path, cancel_at).points


def test_the_policy_learns_from_the_discriminator_and_not_from_the_learned_reward(
    task: ImitationTask, finished: FinishedTraining, tmp_path: Path
) -> None:
    def trained(other: ImitationTask, name: str) -> dict[str, torch.Tensor]:
        folder = tmp_path / name
        folder.mkdir()
        train_imitator(other, folder / "imitator.zip", folder, RecordingProgress())
        return weights(folder / "imitator.zip")

    assert same(trained(replace(task, model=random_model(5.0, 9.0)), "a"), finished.weights)
    unlike = replace(task, perfect=[short_recording(b"\x00" * 120)])
    assert not same(trained(unlike, "b"), finished.weights)


def test_the_reward_is_the_discriminators_own_model(
    task: ImitationTask, finished: FinishedTraining, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A copy, as another device would need, would never learn."""
    monkeypatch.setattr(RewardModel, "on", lambda model, device: deepcopy(model))
    train_imitator(task, tmp_path / "imitator.zip", tmp_path, RecordingProgress())
    assert same(weights(tmp_path / "imitator.zip"), finished.weights)


def test_gail_needs_a_perfect_demonstration(task: ImitationTask, tmp_path: Path) -> None:
    with pytest.raises(Invalid, match="at least one perfect demonstration"):
        train_imitator(replace(task, perfect=[]), tmp_path / "a.zip", tmp_path, RecordingProgress())
