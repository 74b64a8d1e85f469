from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest
import torch

from tests.trainer.samples import (
    STEPS,
    FinishedTraining,
    RecordingProgress,
    imitation_task,
    same,
    tiny_recipe,
    weights,
)
from testsupport.space_invaders import evaluation_start, idle_frames
from trainer.policy import imitation, imitator
from trainer.policy.evaluation import play
from trainer.policy.imitation import (
    ImitationTask,
    best_mixture,
    snapshot_starts,
    training_starts,
)
from trainer.policy.imitator import train_imitator
from trainer.policy.networks import load_network, load_policy, pretrained_policy
from trainer.policy.ppo import ImitationPPO
from trainer.policy.reward_shaping import RewardShaping
from trainer.progress import NullProgress
from tril.errors import Invalid
from tril.games.atari.starts import TRAINING_IDLE_FRAMES
from tril.games.base import start_of
from tril.games.space_invaders import SPACE_INVADERS
from tril.recipes import FAST, evaluated_on_own_start, with_values


@pytest.fixture(scope="module")
def task(tmp_path_factory: pytest.TempPathFactory) -> ImitationTask:
    return replace(imitation_task(tmp_path_factory.mktemp("clone")), perfect=())


@pytest.fixture(scope="module")
def finished(task: ImitationTask, tmp_path_factory: pytest.TempPathFactory) -> FinishedTraining:
    return FinishedTraining(train_imitator, task, tmp_path_factory.mktemp("training") / "whole")


def test_every_rollout_has_a_point_on_the_curves(finished: FinishedTraining) -> None:
    steps = [done for done, _ in finished.progress.points]
    assert steps == [32, 64, 96, 128]
    assert (finished.progress.done[0], finished.progress.totals) == (0, {STEPS})
    always = {"steps_per_s", "entropy", "value_loss", "kl", "kl_to_start"}
    assert all(always <= set(values) for _, values in finished.progress.points)
    assert all(np.isfinite(list(values.values())).all() for _, values in finished.progress.points)


def test_the_best_snapshot_by_the_learned_reward_is_saved(
    task: ImitationTask, finished: FinishedTraining
) -> None:
    snapshots = finished.result.snapshots
    assert [snapshot.steps for snapshot in snapshots] == [0, 64, 128]
    best = max(snapshots, key=lambda snapshot: (snapshot.predicted_return, snapshot.steps))
    assert finished.result.best_steps == best.steps
    games = play(
        SPACE_INVADERS,
        load_policy(finished.path),
        snapshot_starts(SPACE_INVADERS, task.recipe),
        "greedy",
        model=task.model,
    )
    shaping = RewardShaping.of(task.model, task.recipe.policy)
    returns = [shaping.shaped_return(g.rewards, g.died) for g in games if g.rewards is not None]
    assert np.mean(returns) == pytest.approx(best.predicted_return, rel=1e-3, abs=1e-2)


def test_a_training_that_makes_the_policy_worse_ends_with_its_start(
    task: ImitationTask, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    returns = iter((3.0, 2.0, 1.0))
    monkeypatch.setattr(imitator, "evaluate_snapshot", lambda *_: (next(returns), []))
    scratch, saved = tmp_path / "scratch", tmp_path / "imitator.zip"
    scratch.mkdir()
    shown: list[int] = []
    result = train_imitator(
        task, saved, scratch, NullProgress(), on_snapshot=lambda taken: shown.append(taken.steps)
    )
    assert result.best_steps == 0
    # Only what has learned something is shown.
    assert shown == [64, 128]
    assert task.start_policy is not None
    start, ended = load_network(task.start_policy), load_network(saved)
    assert same(start.state_dict(), ended.state_dict())


# While its start is judged, and twice while its first snapshot is.
@pytest.mark.parametrize("cancel_at", [45, 163, 180])
def test_an_interrupted_training_ends_with_the_same_weights(
    finished: FinishedTraining, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, cancel_at: int
) -> None:
    monkeypatch.setattr(imitator, "CHECKPOINT_INTERVAL_S", 0.0)
    finished.check_interrupted(tmp_path, cancel_at)


def test_curves_continue_after_a_checkpoint_of_a_version_with_other_names(
    task: ImitationTask,
) -> None:
    progress = RecordingProgress()
    reporter = imitator._Reporter(task, progress)
    reporter.ppo = cast("ImitationPPO", SimpleNamespace(num_timesteps=64, update_metrics={}))
    reporter.recent.extend([{"hit_share": 1.0}, {"death_rate": 0.0}, {"death_rate": 1.0}])
    reporter.report_rollout({})
    assert progress.curves == [(64, {"death_rate": 0.5})]


def test_a_finished_training_is_not_trained_again(
    task: ImitationTask, finished: FinishedTraining, tmp_path: Path
) -> None:
    progress = RecordingProgress()
    result = train_imitator(task, tmp_path / "again.zip", finished.folder, progress)
    assert result == finished.result
    assert set(progress.done) == {STEPS}
    assert same(weights(tmp_path / "again.zip"), finished.weights)


def test_another_training_seed_gives_another_policy(
    task: ImitationTask, finished: FinishedTraining, tmp_path: Path
) -> None:
    other = replace(task, training_seed=12, steps=STEPS // 4)
    train_imitator(other, tmp_path / "imitator.zip", tmp_path, NullProgress())
    assert not same(weights(tmp_path / "imitator.zip"), finished.weights)


def test_a_training_from_scratch_needs_no_demonstration_states(
    task: ImitationTask, tmp_path: Path
) -> None:
    recipe = tiny_recipe(
        warm_start=False, demonstration_share=0.0, reward="sigmoid", critic_warm_up_steps=0
    )
    plain = replace(task, recipe=recipe, behaviour=None, recordings=[], start_policy=None)
    progress = RecordingProgress()
    train_imitator(plain, tmp_path / "imitator.zip", tmp_path, progress)
    assert not any("hits" in values for _, values in progress.points)


def test_a_warm_start_needs_a_policy_of_the_same_network(
    task: ImitationTask, tmp_path: Path
) -> None:
    without = replace(task, start_policy=None)
    with pytest.raises(Invalid, match="needs a policy to begin with"):
        train_imitator(without, tmp_path / "a.zip", tmp_path, RecordingProgress())
    other = replace(task.recipe, policy=replace(task.recipe.policy, network="nature"))
    with pytest.raises(Invalid, match=r"which is 'nature'; clone.zip has another one"):
        train_imitator(
            replace(task, recipe=other), tmp_path / "a.zip", tmp_path, RecordingProgress()
        )


def test_a_mixed_start_is_the_mixture_of_the_highest_return(
    task: ImitationTask, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    recipe = tiny_recipe(mixed_start=True, kl_coef=0.0, freeze_convolutions=True)
    shaping = RewardShaping.of(task.model, recipe.policy)
    assert task.start_policy is not None
    clone = load_network(task.start_policy)
    learned, shipped = dict(clone.state_dict()), pretrained_policy(0.0).state_dict()
    learned = {name: one.clone() for name, one in learned.items()}
    returns = iter([1.0, 3.0, 2.0, 0.0, 3.0])
    monkeypatch.setattr(imitation, "mean_return", lambda *_: next(returns))
    monkeypatch.setattr(imitation, "play", lambda *_, **__: [])
    mixed = best_mixture(replace(task, recipe=recipe), clone, shaping, lambda: None).state_dict()
    for name, weight in mixed.items():
        expected = 0.75 * shipped[name] + 0.25 * learned[name]
        assert torch.allclose(weight, expected, atol=1e-6), name


def test_a_training_begins_with_its_mixed_start(task: ImitationTask, tmp_path: Path) -> None:
    # Only the critic learns, so that the actor is as it began.
    recipe = tiny_recipe(mixed_start=True, kl_coef=0.0, critic_warm_up_steps=2 * STEPS)
    begun = replace(task, recipe=recipe)
    assert begun.start_policy is not None
    shaping = RewardShaping.of(task.model, recipe.policy)
    mixed = best_mixture(begun, load_network(begun.start_policy), shaping, lambda: None)
    train_imitator(begun, tmp_path / "imitator.zip", tmp_path, NullProgress())
    learned = load_network(tmp_path / "imitator.zip").state_dict()
    assert torch.allclose(learned["action_net.bias"], mixed.state_dict()["action_net.bias"])


def test_an_imitator_that_is_continued_is_not_mixed(
    task: ImitationTask, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(imitator, "best_mixture", lambda *_: pytest.fail("mixed"))
    recipe = tiny_recipe(mixed_start=True, kl_coef=0.0, critic_warm_up_steps=2 * STEPS)
    continued = replace(task, recipe=recipe, mixes_start=False)
    assert continued.start_policy is not None
    train_imitator(continued, tmp_path / "imitator.zip", tmp_path, NullProgress())
    learned = load_network(tmp_path / "imitator.zip").state_dict()
    start = load_network(continued.start_policy).state_dict()
    assert torch.allclose(learned["action_net.bias"], start["action_net.bias"])


def test_snapshots_are_judged_on_training_starts_only() -> None:
    for count in (1, 12, 96, 200):
        starts = snapshot_starts(
            SPACE_INVADERS, with_values(FAST, {"policy.snapshot_episodes": count})
        )
        idle = {idle_frames(start_of(one)) for one in starts}
        assert len(idle) == min(count, 96)
        assert idle <= set(TRAINING_IDLE_FRAMES)


def test_the_published_protocol_trains_and_judges_on_one_start() -> None:
    recipe = evaluated_on_own_start(FAST, 2)
    assert snapshot_starts(SPACE_INVADERS, recipe) == [evaluation_start(2)]
    assert training_starts(SPACE_INVADERS, recipe) == (evaluation_start(2),)
    assert (recipe.evaluation.start_numbers, recipe.evaluation.further_start_numbers) == ((2,), ())


def test_a_method_of_an_earlier_version_is_refused(task: ImitationTask, tmp_path: Path) -> None:
    former = replace(task.recipe, method="dagger")  # type: ignore[arg-type]
    with pytest.raises(Invalid, match="no longer has"):
        train_imitator(
            replace(task, recipe=former), tmp_path / "policy.zip", tmp_path, NullProgress()
        )
