import zipfile
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch

from tests.trainer.policy.made_up import (
    random_model,
    short_recording,
    tiny_recipe,
)
from trainer.policy import imitator
from trainer.policy.evaluation import play
from trainer.policy.imitator import (
    ImitationTask,
    idle_frames_of,
    judging_starts,
    train_imitator,
)
from trainer.policy.networks import load_policy, new_policy, save_policy
from trainer.policy.reward_shaping import RewardShaping
from trainer.progress import RunCancelled
from tril.behaviours import BUILT_IN
from tril.errors import Invalid
from tril.game.starts import TRAINING_IDLE_FRAMES, evaluation_start
from tril.recipes import DAGGER, FAST, judged_where_trained, with_values

STEPS = 128


class Watched:
    """Keeps what it is told and stops when it is told to."""

    def __init__(self, stop_at_tick: int | None = None) -> None:
        self.points: list[tuple[int, dict[str, float]]] = []
        self.done: list[int] = []
        self._stop_at_tick = stop_at_tick

    def advance(self, done: int, total: int, values: Mapping[str, float] | None = None) -> None:
        assert total == STEPS
        self.done.append(done)
        if values:
            self.points.append((done, dict(values)))
        if len(self.done) == self._stop_at_tick:
            raise RunCancelled


@pytest.fixture(scope="module")
def task(tmp_path_factory: pytest.TempPathFactory) -> ImitationTask:
    clone = tmp_path_factory.mktemp("clone") / "clone.zip"
    save_policy(new_policy("small", 1e-3, np.random.default_rng(8)), clone)
    worse = short_recording(b"\x00" * 80)
    return ImitationTask(
        model=random_model(),
        recordings=[short_recording(), worse],
        tiers=[[0], [1]],
        recipe=tiny_recipe(),
        steps=STEPS,
        training_seed=11,
        behaviour=BUILT_IN[0],
        clone=clone,
    )


def weights(path: Path) -> dict[str, torch.Tensor]:
    with zipfile.ZipFile(path) as archive, archive.open("policy.pth") as file:
        loaded: dict[str, torch.Tensor] = torch.load(file, weights_only=True)
        return loaded


def same(one: dict[str, torch.Tensor], other: dict[str, torch.Tensor]) -> bool:
    return all(torch.equal(tensor, other[name]) for name, tensor in one.items())


class Finished:
    def __init__(self, task: ImitationTask, folder: Path) -> None:
        folder.mkdir()
        self.folder = folder
        self.progress = Watched()
        self.path = folder / "imitator.zip"
        self.result = train_imitator(task, self.path, folder, self.progress)
        self.weights = weights(self.path)


@pytest.fixture(scope="module")
def finished(task: ImitationTask, tmp_path_factory: pytest.TempPathFactory) -> Finished:
    return Finished(task, tmp_path_factory.mktemp("training") / "whole")


def test_every_rollout_has_a_point_on_the_curves(finished: Finished) -> None:
    steps = [done for done, _ in finished.progress.points]
    assert steps == [32, 64, 96, 128]
    assert finished.progress.done[0] == 0
    always = {"steps_per_s", "entropy", "value_loss", "kl", "pull"}
    assert all(always <= set(values) for _, values in finished.progress.points)
    assert all(np.isfinite(list(values.values())).all() for _, values in finished.progress.points)


def test_the_best_snapshot_by_the_learned_reward_is_saved(
    task: ImitationTask, finished: Finished
) -> None:
    snapshots = finished.result.snapshots
    assert [snapshot.steps for snapshot in snapshots] == [64, 128]
    best = max(snapshots, key=lambda snapshot: (snapshot.predicted_return, snapshot.steps))
    assert finished.result.best_steps == best.steps
    games = play(
        load_policy(finished.path), judging_starts(task.recipe), "greedy", model=task.model
    )
    payment = RewardShaping.of(task.model, task.recipe.policy)
    totals = [payment.total(game.rewards, game.end) for game in games if game.rewards is not None]
    assert np.mean(totals) == pytest.approx(best.predicted_return, rel=1e-3, abs=1e-2)


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
        train_imitator(task, path, tmp_path, interrupted)
    assert not path.exists()
    resumed = Watched()
    result = train_imitator(task, path, tmp_path, resumed)
    assert same(weights(path), finished.weights)
    assert result == finished.result
    # The curve goes on where the checkpoint was, without a gap or a jump.
    begun = resumed.done[0]
    assert begun <= interrupted.done[-1]
    without_rates = [
        [(done, {k: v for k, v in values.items() if k != "steps_per_s"}) for done, values in points]
        for points in (
            [p for p in interrupted.points if p[0] <= begun] + resumed.points,
            finished.progress.points,
        )
    ]
    assert without_rates[0] == without_rates[1]


def test_a_finished_training_is_not_trained_again(
    task: ImitationTask, finished: Finished, tmp_path: Path
) -> None:
    progress = Watched()
    result = train_imitator(task, tmp_path / "again.zip", finished.folder, progress)
    assert result == finished.result
    assert set(progress.done) == {STEPS}
    assert same(weights(tmp_path / "again.zip"), finished.weights)


def test_another_training_seed_gives_another_policy(
    task: ImitationTask, finished: Finished, tmp_path: Path
) -> None:
    other = replace(task, training_seed=12, steps=STEPS // 4)

    class Quiet:
        def advance(self, done: int, total: int, values: object = None) -> None: ...

    train_imitator(other, tmp_path / "imitator.zip", tmp_path, Quiet())
    assert not same(weights(tmp_path / "imitator.zip"), finished.weights)


def test_a_training_from_scratch_needs_no_demonstration_states(
    task: ImitationTask, tmp_path: Path
) -> None:
    recipe = tiny_recipe(
        warm_start=False, demonstration_share=0.0, reward="sigmoid", critic_warm_up_steps=0
    )
    plain = replace(task, recipe=recipe, behaviour=None, recordings=[], clone=None)
    progress = Watched()
    train_imitator(plain, tmp_path / "imitator.zip", tmp_path, progress)
    assert not any("hits" in values for _, values in progress.points)


def test_a_warm_start_needs_a_clone_of_the_same_network(
    task: ImitationTask, tmp_path: Path
) -> None:
    with pytest.raises(Invalid, match="begins with the run's clone"):
        train_imitator(replace(task, clone=None), tmp_path / "a.zip", tmp_path, Watched())
    other = replace(task.recipe, cloning=replace(task.recipe.cloning, network="nature"))
    with pytest.raises(Invalid, match="of the same network"):
        train_imitator(replace(task, recipe=other), tmp_path / "a.zip", tmp_path, Watched())


def test_snapshots_are_judged_on_training_starts_only() -> None:
    for count in (1, 12, 96, 200):
        starts = judging_starts(with_values(FAST, {"policy.snapshot_episodes": count}))
        assert len({start.idle_frames for start in starts}) == min(count, 96)
        assert {start.idle_frames for start in starts} <= set(TRAINING_IDLE_FRAMES)


def test_the_published_protocol_trains_and_judges_on_one_start() -> None:
    recipe = judged_where_trained(FAST, 2)
    assert judging_starts(recipe) == [evaluation_start(2)]
    assert idle_frames_of(recipe) == (evaluation_start(2).idle_frames,)
    assert (recipe.evaluation.start_numbers, recipe.evaluation.further_start_numbers) == ((2,), ())
    with pytest.raises(Invalid, match="DAgger"):
        judged_where_trained(DAGGER, 2)
