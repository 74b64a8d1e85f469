from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch

from tests.trainer.planted import planted_trajectories, planted_trajectory
from tests.trainer.policy.made_up import ELSEWHERE
from trainer.progress import NullProgress, Progress, RunCancelled
from trainer.reward import reward_trainer
from trainer.reward.check import are_told_apart, check_ranking
from trainer.reward.model import RewardModel, RewardNetwork, predicted_return
from trainer.reward.preference_dataset import compare
from trainer.reward.reward_trainer import LEVEL_STEPS, train_reward_model
from tril.recipes import FAST, PAPER, RewardRecipe

TRAJECTORIES = planted_trajectories()
TIERS = [[0], [1], [2, 3], [4], [5]]
RECIPES = {
    "fast": replace(
        FAST.reward,
        updates=25,
        folds=3,
        fold_updates=25,
        fold_stride=0,
        observation_stride=5,
        fragment_min_steps=5,
    ),
    "paper": replace(
        PAPER.reward,
        updates=120,
        fold_updates=60,
        fragment_pairs=50,
        learning_rate=5e-4,
        fragment_min_steps=10,
        fragment_max_steps=20,
    ),
}


@pytest.fixture(scope="module", params=RECIPES)
def recipe(request: pytest.FixtureRequest) -> RewardRecipe:
    return RECIPES[request.param]


@pytest.fixture(scope="module")
def model(recipe: RewardRecipe) -> RewardModel:
    return train_reward_model(TRAJECTORIES, TIERS, recipe, 7, NullProgress())


def test_a_planted_better_trajectory_is_ranked_higher(model: RewardModel) -> None:
    rng = np.random.default_rng(99)
    better = planted_trajectory(rng, 4, 40).observations
    worse = planted_trajectory(rng, 1, 40).observations
    assert predicted_return(model, better) > predicted_return(model, worse)


def test_the_same_training_seed_gives_the_same_model(
    recipe: RewardRecipe, model: RewardModel
) -> None:
    again = train_reward_model(TRAJECTORIES, TIERS, recipe, 7, NullProgress())
    for one, other in zip(model.members, again.members, strict=True):
        for a, b in zip(one.parameters(), other.parameters(), strict=True):
            assert torch.equal(a, b)
    assert (again.offsets, again.scales, again.one) == (model.offsets, model.scales, model.one)
    short = replace(recipe, updates=2)
    different = train_reward_model(TRAJECTORIES, TIERS, short, 8, NullProgress())
    assert not torch.equal(different.members[0].hidden.weight, model.members[0].hidden.weight)


def test_a_good_model_passes_the_check(recipe: RewardRecipe, model: RewardModel) -> None:
    # Games of different lengths have returns that do not compare: all equally long here.
    rng = np.random.default_rng(5)
    trajectories = [planted_trajectory(rng, quality, 40) for quality in (5, 4, 3, 2, 1, 0)]
    check = check_ranking(model, trajectories, TIERS, recipe, 7, NullProgress())
    assert check.tau >= 0.9
    assert check.pair_accuracy > 0.8
    assert check.held_out_accuracy is not None
    assert check.held_out_accuracy >= 0.9
    assert check.passed
    assert set(check.predicted_returns) == set(range(6))


def test_a_contradictory_ranking_fails_the_check_and_names_the_tiers() -> None:
    recipe = replace(RECIPES["fast"], updates=10, fold_updates=10)
    rng = np.random.default_rng(2)
    # Four games of the same quality, one of them ranked above and one below the better two.
    trajectories = [planted_trajectory(rng, quality, 40) for quality in (0, 5, 4, 0, 5, 0)]
    tiers = [[i] for i in range(6)]
    model = train_reward_model(trajectories, tiers, recipe, 1, NullProgress())
    check = check_ranking(model, trajectories, tiers, recipe, 1, NullProgress())
    assert not check.passed
    assert check.confused
    assert all(1 <= pair.better < pair.worse <= 6 for pair in check.confused)
    assert all(pair.n_right < pair.n_compared for pair in check.confused)


def test_two_tiers_without_a_difference_are_not_told_apart_though_the_check_passes() -> None:
    rng = np.random.default_rng(5)
    qualities = (6, 5, 4, 3, 2, 1, 0, 0, 1)
    trajectories = [planted_trajectory(rng, quality, 40) for quality in qualities]
    tiers = [[0], [1], [2], [3], [4], [5, 6], [7, 8]]
    recipe = RECIPES["fast"]
    model = train_reward_model(trajectories, tiers, recipe, 1, NullProgress())
    check = check_ranking(model, trajectories, tiers, recipe, 1, NullProgress())
    assert check.passed, check
    assert check.not_told_apart == [(6, 7)]


def test_the_fewer_comparisons_the_closer_to_chance_they_have_to_be() -> None:
    bounds = {
        n: max(right for right in range(n + 1) if not are_told_apart(right, n))
        for n in (1, 2, 3, 6, 10, 20, 1000)
    }
    assert bounds == {1: 0, 2: 1, 3: 1, 6: 4, 10: 7, 20: 15, 1000: 781}


def test_an_ensemble_has_different_members_on_one_scale() -> None:
    recipe = replace(RECIPES["fast"], updates=10, ensemble=2)
    model = train_reward_model(TRAJECTORIES, TIERS, recipe, 7, NullProgress())
    first, second = model.members
    assert not torch.equal(first.hidden.weight, second.hidden.weight)
    states = np.concatenate([t.observations for t in TRAJECTORIES])
    for member, offset, scale in zip(model.members, model.offsets, model.scales, strict=True):
        scores = RewardModel((member,), (offset,), (scale,)).score(states)
        assert scores.std() == pytest.approx(1.0, rel=1e-3)


def test_standardised_rewards_put_the_worst_tier_at_zero() -> None:
    model = train_reward_model(TRAJECTORIES, TIERS, RECIPES["fast"], 7, NullProgress())
    means = [
        np.mean([model.score(TRAJECTORIES[i].observations).mean() for i in tier]) for tier in TIERS
    ]
    assert min(means) == pytest.approx(0.0, abs=1e-4)


def test_levels_go_from_the_beginnings_to_the_ends_of_the_best() -> None:
    model = train_reward_model(TRAJECTORIES, TIERS, RECIPES["fast"], 7, NullProgress())
    levels = [model.level(model.score(t.observations)) for t in TRAJECTORIES]
    beginnings = np.mean([values[:LEVEL_STEPS].mean() for values in levels])
    assert beginnings == pytest.approx(0.0, abs=1e-3)
    assert levels[0][-LEVEL_STEPS:].mean() == pytest.approx(1.0, abs=1e-3)


class Recorded:
    def __init__(self, stop_at: int | None = None) -> None:
        self.done: list[tuple[int, int]] = []
        self.values: list[Mapping[str, float]] = []
        self.stop_at = stop_at

    def advance(self, done: int, total: int, values: Mapping[str, float] | None = None) -> None:
        self.done.append((done, total))
        if values:
            self.values.append(values)
        if len(self.done) == self.stop_at:
            raise RunCancelled


def test_progress_is_told_after_every_update(recipe: RewardRecipe) -> None:
    progress = Recorded()
    train_reward_model(TRAJECTORIES, TIERS, replace(recipe, updates=3), 7, progress)
    assert len(progress.done) == 3
    assert progress.done[-1][0] == progress.done[-1][1]
    assert [set(values) for values in progress.values] == [{"loss", "accuracy"}] * 3


def test_an_interrupted_training_gives_the_same_model(
    recipe: RewardRecipe, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(reward_trainer, "CHECKPOINT_EVERY_S", 0.0)
    recipe = replace(recipe, updates=4, ensemble=2, fragment_pairs=3)
    whole = Recorded()
    expected = train_reward_model(TRAJECTORIES, TIERS, recipe, 7, whole)
    interrupted = Recorded(stop_at=7)
    with pytest.raises(RunCancelled):
        train_reward_model(TRAJECTORIES, TIERS, recipe, 7, interrupted, tmp_path)
    resumed = Recorded()
    model = train_reward_model(TRAJECTORIES, TIERS, recipe, 7, resumed, tmp_path)
    for one, other in zip(model.members, expected.members, strict=True):
        for a, b in zip(one.parameters(), other.parameters(), strict=True):
            assert torch.equal(a, b)
    # The first member was finished, the second had two of its four updates on disk.
    assert resumed.done == [(4, 8), (6, 8), (7, 8), (8, 8)]
    assert interrupted.values[:6] + resumed.values == whole.values


def test_an_interrupted_check_gives_the_same_accuracy(
    model: RewardModel, recipe: RewardRecipe, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(reward_trainer, "CHECKPOINT_EVERY_S", 0.0)
    recipe = replace(recipe, fold_updates=3, folds=2)
    expected = check_ranking(model, TRAJECTORIES, TIERS, recipe, 7, NullProgress())
    with pytest.raises(RunCancelled):
        check_ranking(model, TRAJECTORIES, TIERS, recipe, 7, Recorded(stop_at=6), tmp_path)
    resumed = Recorded()
    assert check_ranking(model, TRAJECTORIES, TIERS, recipe, 7, resumed, tmp_path) == expected
    assert resumed.done[0] == (3, 6)
    assert {name for values in resumed.values for name in values} == {"held_out_accuracy"}


def test_a_fold_learns_in_its_own_way(
    model: RewardModel, recipe: RewardRecipe, monkeypatch: pytest.MonkeyPatch
) -> None:
    learned: list[RewardRecipe] = []
    train = reward_trainer.RewardTrainer.train

    def note(job: reward_trainer.RewardTrainer, progress: Progress) -> RewardNetwork:
        learned.append(job._logits._recipe)
        return train(job, progress)

    monkeypatch.setattr(reward_trainer.RewardTrainer, "train", note)
    recipe = replace(recipe, folds=2, fold_updates=1, fold_stride=7)
    check_ranking(model, TRAJECTORIES, TIERS, recipe, 7, NullProgress())
    assert [one.observation_stride for one in learned] == [7, 7]
    check_ranking(model, TRAJECTORIES, TIERS, replace(recipe, fold_stride=0), 7, NullProgress())
    assert [one.observation_stride for one in learned[2:]] == [recipe.observation_stride] * 2


def test_cancelling_stops_at_once(recipe: RewardRecipe) -> None:
    progress = Recorded(stop_at=2)
    with pytest.raises(RunCancelled):
        train_reward_model(TRAJECTORIES, TIERS, recipe, 7, progress)
    assert len(progress.done) == 2


@pytest.mark.parametrize("name", ["fast", "paper"])
def test_a_loss_is_computed_where_the_network_is(name: str) -> None:
    comparisons = compare(TRAJECTORIES, TIERS, RECIPES[name])
    job = reward_trainer.RewardTrainer(comparisons, 2, (7,), device=ELSEWHERE)
    logits = job._logits(0)
    assert logits.device == ELSEWHERE
    logits.sum().backward()  # type: ignore[no-untyped-call]
    gradients = [parameter.grad for parameter in job.network.parameters()]
    assert all(one is not None and one.device == ELSEWHERE for one in gradients)
