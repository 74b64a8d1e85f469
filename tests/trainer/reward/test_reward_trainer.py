from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch

from tests.trainer.samples import (
    ELSEWHERE,
    REWARD_RECIPE,
    TIERS,
    RecordingProgress,
    planted_trajectories,
    planted_trajectory,
    same,
)
from trainer.progress import NullProgress, RunCancelled
from trainer.reward import reward_trainer
from trainer.reward.check import are_distinguished, check_ranking
from trainer.reward.model import RewardModel, predicted_return
from trainer.reward.preference_dataset import PreferenceDataset
from trainer.reward.reward_trainer import RewardTrainer, train_reward_model
from tril.errors import Invalid
from tril.recipes import FAST, RewardRecipe
from tril.recording import LEVEL_STEPS

TRAJECTORIES = planted_trajectories()


def planted(recipe: RewardRecipe) -> PreferenceDataset:
    return PreferenceDataset.from_demonstrations(TRAJECTORIES, TIERS, recipe)


def of_qualities(
    qualities: Sequence[int], tiers: Sequence[Sequence[int]], recipe: RewardRecipe
) -> PreferenceDataset:
    """Return equally long trajectories: those of other lengths have returns that don't compare."""
    rng = np.random.default_rng(5)
    trajectories = [planted_trajectory(rng, quality, 40) for quality in qualities]
    return PreferenceDataset.from_demonstrations(trajectories, tiers, recipe)


@pytest.fixture(scope="module")
def model() -> RewardModel:
    return train_reward_model(planted(REWARD_RECIPE), 7, NullProgress())


def test_a_planted_better_trajectory_is_ranked_higher(model: RewardModel) -> None:
    rng = np.random.default_rng(99)
    better = planted_trajectory(rng, 4, 40).observations
    worse = planted_trajectory(rng, 1, 40).observations
    assert predicted_return(model, better) > predicted_return(model, worse)


def weights_of(model: RewardModel) -> dict[str, torch.Tensor]:
    return model.network.state_dict()


def test_the_same_training_seed_gives_the_same_model(model: RewardModel) -> None:
    again = train_reward_model(planted(REWARD_RECIPE), 7, NullProgress())
    assert same(weights_of(model), weights_of(again))
    assert (again.zero, again.one) == (model.zero, model.one)
    different = train_reward_model(planted(replace(REWARD_RECIPE, updates=2)), 8, NullProgress())
    assert not same(weights_of(model), weights_of(different))


def test_a_good_model_passes_the_check(model: RewardModel) -> None:
    dataset = of_qualities((5, 4, 3, 2, 1, 0), TIERS, REWARD_RECIPE)
    check, _ = check_ranking(model, dataset, 7, NullProgress())
    assert check.tau >= 0.9
    assert check.pair_accuracy > 0.8
    assert check.held_out_accuracy is not None
    assert check.held_out_accuracy >= 0.9
    assert check.passed
    assert set(check.predicted_returns) == set(range(6))


def test_a_contradictory_ranking_fails_the_check_and_names_the_tiers() -> None:
    recipe = replace(REWARD_RECIPE, updates=10, fold_updates=10)
    # Three games of the same quality, one of them ranked above the better ones.
    dataset = of_qualities((0, 5, 4, 0, 5, 0), [[i] for i in range(6)], recipe)
    model = train_reward_model(dataset, 1, NullProgress())
    check, _ = check_ranking(model, dataset, 1, NullProgress())
    assert not check.passed
    assert check.confused
    assert all(1 <= pair.better < pair.worse <= 6 for pair in check.confused)
    assert all(pair.n_right < pair.n_compared for pair in check.confused)


def test_two_tiers_without_a_difference_are_not_told_apart_though_the_check_passes() -> None:
    tiers = [[0], [1], [2], [3], [4], [5, 6], [7, 8]]
    dataset = of_qualities((6, 5, 4, 3, 2, 1, 0, 0, 1), tiers, REWARD_RECIPE)
    model = train_reward_model(dataset, 1, NullProgress())
    check, _ = check_ranking(model, dataset, 1, NullProgress())
    assert check.passed, check
    assert check.not_told_apart == [(6, 7)]


def test_the_fewer_comparisons_the_closer_to_chance_they_have_to_be() -> None:
    bounds = {
        n: max(right for right in range(n + 1) if not are_distinguished(right, n))
        for n in (1, 2, 3, 6, 10, 20, 1000)
    }
    assert bounds == {1: 0, 2: 1, 3: 1, 6: 4, 10: 7, 20: 15, 1000: 781}


def test_levels_go_from_the_beginnings_of_games_to_the_best_ones_end(model: RewardModel) -> None:
    levels = [model.level(model.score(trajectory.observations)) for trajectory in TRAJECTORIES]
    beginnings = np.mean([values[:LEVEL_STEPS].mean() for values in levels])
    assert beginnings == pytest.approx(0.0, abs=1e-3)
    assert levels[0][-LEVEL_STEPS:].mean() == pytest.approx(1.0, abs=1e-3)


def test_a_pretrained_reward_is_standardised_and_puts_the_worst_tier_at_zero() -> None:
    recipe = replace(FAST.reward, updates=4, fragment_min_steps=4)
    model = train_reward_model(planted(recipe), 7, NullProgress())
    rewards = [model.score(trajectory.observations) for trajectory in TRAJECTORIES]
    assert np.concatenate(rewards).std() == pytest.approx(1.0, rel=1e-3)
    means = [np.mean([rewards[i].mean() for i in tier]) for tier in TIERS]
    assert min(means) == pytest.approx(0.0, abs=1e-4)


def test_progress_is_reported_after_every_update() -> None:
    progress = RecordingProgress()
    train_reward_model(planted(replace(REWARD_RECIPE, updates=3)), 7, progress)
    assert (progress.done, progress.totals) == ([1, 2, 3], {3})
    assert [set(values) for _, values in progress.points] == [{"loss", "accuracy"}] * 3


def test_an_interrupted_training_gives_the_same_model(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(reward_trainer, "CHECKPOINT_INTERVAL_S", 0.0)
    recipe = replace(REWARD_RECIPE, updates=4, fragment_pairs=3)
    whole, interrupted, resumed = (
        RecordingProgress(),
        RecordingProgress(cancel_at=3),
        RecordingProgress(),
    )
    expected = train_reward_model(planted(recipe), 7, whole)
    with pytest.raises(RunCancelled):
        train_reward_model(planted(recipe), 7, interrupted, tmp_path)
    model = train_reward_model(planted(recipe), 7, resumed, tmp_path)
    assert same(weights_of(model), weights_of(expected))
    # Two of the four updates were on disk.
    assert (resumed.done, resumed.totals) == ([2, 3, 4], {4})
    assert interrupted.points[:2] + resumed.points == whole.points


def test_an_interrupted_check_gives_the_same_accuracy(
    model: RewardModel, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(reward_trainer, "CHECKPOINT_INTERVAL_S", 0.0)
    dataset = planted(replace(REWARD_RECIPE, fold_updates=3, folds=2))
    expected, _ = check_ranking(model, dataset, 7, NullProgress())
    with pytest.raises(RunCancelled):
        check_ranking(model, dataset, 7, RecordingProgress(cancel_at=6), tmp_path)
    resumed = RecordingProgress()
    assert check_ranking(model, dataset, 7, resumed, tmp_path)[0] == expected
    assert (resumed.done[0], resumed.totals) == (3, {6})
    assert {name for _, values in resumed.points for name in values} == {"held_out_accuracy"}


def test_cancelling_stops_at_once() -> None:
    progress = RecordingProgress(cancel_at=2)
    with pytest.raises(RunCancelled):
        train_reward_model(planted(REWARD_RECIPE), 7, progress)
    assert len(progress.done) == 2


def test_a_loss_is_computed_where_the_network_is() -> None:
    trainer = RewardTrainer(planted(REWARD_RECIPE), 2, (7,), device=ELSEWHERE)
    logits = trainer._logits(0)
    assert logits.device == ELSEWHERE
    logits.sum().backward()  # type: ignore[no-untyped-call]
    gradients = [parameter.grad for parameter in trainer.network.parameters()]
    assert all(one is not None and one.device == ELSEWHERE for one in gradients)


def test_a_method_of_an_earlier_version_is_refused() -> None:
    former = replace(REWARD_RECIPE, method="fast")  # type: ignore[arg-type]
    with pytest.raises(Invalid, match="no longer has"):
        train_reward_model(planted(former), 7, NullProgress())
