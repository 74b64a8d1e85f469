"""GAIL: the discriminator, the reward that follows it, and the training as a whole."""

from __future__ import annotations

from copy import deepcopy
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch

from tests.trainer.policy.made_up import observations, random_model, short_recording, tiny_recipe
from tests.trainer.policy.test_imitator import STEPS, Watched, same, weights
from trainer.policy import imitator
from trainer.policy.discriminator import Discriminator
from trainer.policy.evaluation import play
from trainer.policy.gail import train_by_gail
from trainer.policy.imitator import ImitationTask, ImitatorResult
from trainer.policy.networks import new_policy, save_policy
from trainer.policy.reward_shaping import RewardShaping
from trainer.progress import RunCancelled
from trainer.reward.model import RewardModel
from tril.behaviours import BUILT_IN
from tril.demonstrator import Demonstration, ExampleKind, example_tasks, execute
from tril.errors import Invalid
from tril.game.starts import Start
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
    starts = [Start(idle) for idle in range(0, 120, 10)]
    games = play(Random(), starts, "sampled", n_processes=1)
    return [trajectory(game.recording) for game in games]


def test_the_discriminator_tells_the_expert_from_a_random_policy_and_the_reward_follows(
    shown: list[Demonstration], random_games: list[Trajectory]
) -> None:
    learned_from, left_out = (trajectory(one.recording) for one in shown)
    discriminator = Discriminator(acted_in(learned_from), QUICK, 0)
    first = discriminator.learn(acted_in(*random_games[:-3]), lambda: None)
    for _ in range(3):
        last = discriminator.learn(acted_in(*random_games[:-3]), lambda: None)
    assert first["discriminator_accuracy"] < last["discriminator_accuracy"]
    assert last["discriminator_accuracy"] > 0.9
    assert last["discriminator_loss"] < first["discriminator_loss"]
    # On games of both that it has not seen.
    payment = RewardShaping(discriminator.model, "softplus", 0.0)
    expert = discriminator.model.score(left_out.observations[1:])
    unseen = np.concatenate([one.observations[1:] for one in random_games[-3:]])
    random = discriminator.model.score(unseen)
    assert (expert > 0).mean() > 0.6
    assert (random < 0).mean() > 0.6
    nobody = np.zeros(1, np.bool_)
    paid = [payment.pay(one, one, nobody).mean() for one in (expert, random)]
    assert paid[0] > 1.5 * paid[1] > 0
    np.testing.assert_allclose(
        payment.pay(expert, expert, nobody), -np.log1p(-1 / (1 + np.exp(-expert))), rtol=1e-3
    )


def test_what_pays_changes_only_between_rounds() -> None:
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
    clone = tmp_path_factory.mktemp("clone") / "clone.zip"
    save_policy(new_policy("small", 1e-3, np.random.default_rng(8)), clone)
    recipe = tiny_recipe(reward="softplus", demonstration_share=0.0, kl_coef=0.0, snapshot_steps=())
    return ImitationTask(
        model=random_model(),
        recordings=[],
        tiers=[],
        recipe=replace(recipe, method="gail", gail=GailRecipe(updates=2, batch_size=16)),
        steps=STEPS,
        training_seed=11,
        behaviour=BUILT_IN[0],
        perfect=[short_recording()],
        clone=clone,
    )


class Finished:
    def __init__(self, task: ImitationTask, folder: Path) -> None:
        self.progress = Watched()
        self.path = folder / "imitator.zip"
        self.result = train_by_gail(task, self.path, folder, self.progress)
        self.weights = weights(self.path)


@pytest.fixture(scope="module")
def finished(task: ImitationTask, tmp_path_factory: pytest.TempPathFactory) -> Finished:
    return Finished(task, tmp_path_factory.mktemp("gail"))


def test_the_last_policy_is_kept_and_the_curves_show_the_discriminator(finished: Finished) -> None:
    assert finished.result.best_steps == STEPS
    assert len(finished.result.snapshots) == 1
    points = finished.progress.points
    assert [done for done, _ in points] == [32, 64, 96, 128]
    always = {"discriminator_loss", "discriminator_accuracy", "value_loss", "steps_per_s"}
    assert all(always <= set(values) for _, values in points)
    # What it is paid is no prediction of the learned reward.
    assert not any("predicted_return" in values for _, values in points)


@pytest.mark.parametrize("stop_at_tick", [45, 62])
def test_a_training_that_was_interrupted_ends_with_the_same_weights(
    task: ImitationTask,
    finished: Finished,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    stop_at_tick: int,
) -> None:
    monkeypatch.setattr(imitator, "CHECKPOINT_EVERY_S", 0.0)
    path = tmp_path / "imitator.zip"
    interrupted = Watched(stop_at_tick)
    with pytest.raises(RunCancelled):
        train_by_gail(task, path, tmp_path, interrupted)
    assert not path.exists()
    assert interrupted.points
    resumed = Watched()
    result: ImitatorResult = train_by_gail(task, path, tmp_path, resumed)
    assert same(weights(path), finished.weights)
    assert result == finished.result
    found = [
        (done, values["discriminator_loss"], values["discriminator_accuracy"])
        for done, values in [p for p in interrupted.points if p[0] <= resumed.done[0]]
        + resumed.points
    ]
    assert found == [
        (done, values["discriminator_loss"], values["discriminator_accuracy"])
        for done, values in finished.progress.points
    ]


def test_the_policy_learns_from_the_discriminator_and_not_from_the_learned_reward(
    task: ImitationTask, finished: Finished, tmp_path: Path
) -> None:
    def trained(other: ImitationTask, name: str) -> dict[str, torch.Tensor]:
        folder = tmp_path / name
        folder.mkdir()
        train_by_gail(other, folder / "imitator.zip", folder, Watched())
        return weights(folder / "imitator.zip")

    assert same(trained(replace(task, model=random_model(5.0, 9.0)), "a"), finished.weights)
    unlike = replace(task, perfect=[short_recording(b"\x00" * 120)])
    assert not same(trained(unlike, "b"), finished.weights)


def test_what_pays_is_the_discriminators_own_model(
    task: ImitationTask, finished: Finished, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A copy, as another device would need, would never learn."""
    monkeypatch.setattr(RewardModel, "on", lambda model, device: deepcopy(model))
    train_by_gail(task, tmp_path / "imitator.zip", tmp_path, Watched())
    assert same(weights(tmp_path / "imitator.zip"), finished.weights)


def test_gail_needs_a_perfect_demonstration(task: ImitationTask, tmp_path: Path) -> None:
    with pytest.raises(Invalid, match="at least one perfect demonstration"):
        train_by_gail(replace(task, perfect=[]), tmp_path / "a.zip", tmp_path, Watched())
