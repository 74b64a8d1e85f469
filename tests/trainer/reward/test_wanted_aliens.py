"""A reward of which aliens are wanted, inferred from what games hit."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
import torch
from torch import Tensor

from tests.trainer.samples import RecordingProgress
from trainer.progress import NullProgress, RunCancelled
from trainer.reward import preference_dataset
from trainer.reward.check import check_ranking
from trainer.reward.model import RewardModel, swept_to
from trainer.reward.preference_dataset import PerfectDemonstrations, PreferenceDataset
from trainer.reward.pretraining import pretrained_network
from trainer.reward.reward_trainer import train_reward_model
from trainer.reward.wanted_aliens import WantedAliensTrainer, labels_of, set_labels
from tril.analysis.wanted_aliens import Hits, learned_order
from tril.games.base import Taken
from tril.games.space_invaders.memory import COLUMNS, FRAMES_PER_STEP
from tril.recipes import FAST
from tril.recording import Trajectory

RECIPE = replace(FAST.reward, updates=60, fold_updates=60)

N_STEPS = 200
APART = 12
"""Steps from one hit to the next."""

COLUMN_3 = (2, 8, 14, 20, 26, 32)
ROW_1 = (0, 1, 2, 3, 4, 5)


def read(observations: np.ndarray) -> Tensor:
    """Return what a perfect network would read, which ``game`` writes on its screens."""
    left = torch.from_numpy(observations[:, 0, 0, :36] / 255.0).float()
    return torch.cat([left, swept_to(left)], 1)


@pytest.fixture(autouse=True)
def _networks_that_read_what_is_written(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(preference_dataset, "read_features", read)


def game(aliens: Sequence[int], n_steps: int = N_STEPS) -> Trajectory:
    """Return a game that hits aliens in turn, whose screens hold which are left."""
    screens = np.zeros((n_steps + 1, 4, 84, 84), np.uint8)
    screens[:, 0, 0, :36] = 255
    for number, alien in enumerate(aliens, start=1):
        screens[number * APART :, 0, 0, alien] = 0
    shot = tuple(
        Taken(*divmod(alien, COLUMNS), number * APART * FRAMES_PER_STEP)
        for number, alien in enumerate(aliens, start=1)
    )
    return Trajectory(screens, np.zeros(n_steps, np.int64), shot)


def hits(aliens: Sequence[int], n_steps: int = N_STEPS) -> Hits:
    """Return what such a game hits."""
    shot = game(aliens, n_steps).taken
    return Hits.of([(hit.row, hit.column, hit.frame) for hit in shot], n_steps * FRAMES_PER_STEP)


def dataset(
    ranked: Sequence[Sequence[int]],
    perfect: Sequence[Sequence[int]] = (),
    worst: Sequence[Sequence[int]] = (),
) -> PreferenceDataset:
    """Return the dataset of games by what they hit.

    Args:
        ranked: From best to worst, each in a tier of its own.
        perfect: Perfect ones, which are not ranked.
        worst: Further ranked ones, all in the last tier.
    """
    further = [game(aliens) for aliens in perfect]
    tiers = [[index] for index in range(len(ranked))]
    if worst:
        tiers.append([*range(len(ranked), len(ranked) + len(worst))])
    return PreferenceDataset.from_demonstrations(
        [game(aliens) for aliens in (*ranked, *worst)],
        tiers,
        RECIPE,
        PerfectDemonstrations(further, [None] * len(further)),
    )


def labels(data: PreferenceDataset, seed: int = 0) -> np.ndarray:
    """Return the mean label of each alien, float64 (36,)."""
    return labels_of(WantedAliensTrainer(data, 100, (seed,)).train(NullProgress()))[0]


COLUMN_3_RANKING = [
    COLUMN_3,
    COLUMN_3[:5],
    COLUMN_3[:4],
    COLUMN_3[:3],
    COLUMN_3[:2],
    COLUMN_3[:1],
    (),
    (1,),
    (1, 7, 13),
    (1, 3, 9, 7, 4),
    (1, 3, 9, 7, 4, 0, 10, 6),
]


def test_screens_that_are_misread_at_the_end_do_not_matter(monkeypatch: pytest.MonkeyPatch) -> None:
    data = dataset(COLUMN_3_RANKING, [COLUMN_3] * 6)
    expected = labels(data)

    def misread(observations: np.ndarray) -> Tensor:
        found = read(observations)
        found[-3:, [5, 11, 17, 23, 29, 35]] = 0.0
        return found

    monkeypatch.setattr(preference_dataset, "read_features", misread)
    assert np.array_equal(labels(dataset(COLUMN_3_RANKING, [COLUMN_3] * 6)), expected)


@pytest.mark.parametrize("perfect", [[], [COLUMN_3] * 6])
def test_the_aliens_of_a_column_are_wanted_and_others_are_not(
    perfect: list[tuple[int, ...]],
) -> None:
    found = labels(dataset(COLUMN_3_RANKING, perfect))
    wanted = found[list(COLUMN_3)]
    assert (wanted > 0.6).all(), wanted
    others = np.delete(found, COLUMN_3)
    assert (others < 0.0).all(), others
    assert (others[:4] < -0.5).all(), others


def test_a_few_games_in_wrong_places_change_little() -> None:
    swapped = [*COLUMN_3_RANKING]
    swapped[2], swapped[3] = swapped[3], swapped[2]
    swapped[7], swapped[8] = swapped[8], swapped[7]
    right, wrong = labels(dataset(COLUMN_3_RANKING)), labels(dataset(swapped))
    assert np.array_equal(right > 0, wrong > 0)
    assert np.abs(right - wrong).max() < 0.4


def test_many_games_that_are_wrongly_called_the_worst_change_little() -> None:
    # All of them are better than the three worst of the others.
    varied = [(column,) for column in (0, 1, 3, 4, 5)] * 6
    right = labels(dataset(COLUMN_3_RANKING, [COLUMN_3] * 6))
    wrong = labels(dataset(COLUMN_3_RANKING, [COLUMN_3] * 6, worst=varied))
    assert np.array_equal(right > 0, wrong > 0)


def test_a_row_that_the_best_games_sweep_pays_as_far_as_it_is_swept() -> None:
    ranking = [ROW_1, ROW_1[:5], ROW_1[:4], ROW_1[:3], ROW_1[:1], (), (3,), (3, 2, 9), (3, 8, 9, 2)]
    data = dataset(ranking, [ROW_1] * 3)
    model = train_reward_model(data, 3, NullProgress())

    def level(aliens: Sequence[int]) -> float:
        features = read(game(aliens).observations[-1:])
        return float(model.level(model.score_features(features))[0])

    up_to = [level(ROW_1[:count]) for count in range(7)]
    assert (np.diff(up_to) > 0.1).all(), up_to
    # Out of order the same aliens pay less until the row is complete.
    assert level((0, 2, 3, 4, 5)) < 0.6 * level(ROW_1)
    assert level(ROW_1[::-1]) == pytest.approx(level(ROW_1), abs=0.02)


def test_a_stray_costs_something_in_any_order() -> None:
    # The best games swept row 2 up to its second alien, which others hit alone.
    sweeping = (0, 1, 6, 7)
    ranking = [sweeping, sweeping, (0, 1, 6), (0, 1), (), (2,), (2, 3), (2, 3, 4)]
    network = pretrained_network(np.random.default_rng(0))
    order = learned_order([hits(sweeping)] * 10)
    assert order[7] > 0.8
    set_labels(network, np.full(36, -1.0), order)
    with torch.no_grad():
        nothing, stray = network.from_features(
            torch.cat([read(game(aliens).observations[-1:]) for aliens in ((), (7,))])
        )
    assert stray == pytest.approx(nothing - 1.0)
    assert (labels(dataset(ranking))[[2, 3, 4]] < -0.8).all()


def test_a_large_first_tier_does_not_stand_for_the_best() -> None:
    games = [COLUMN_3] * 4 + [(1, 7)] * 8
    data = dataset([*games, (1, 7), (1, 7)], [COLUMN_3] * 6)
    tiers = (tuple(range(12)), (12, 13))
    found = labels(replace(data, tiers=tiers))
    assert (found[list(COLUMN_3)] > 0.5).all()
    assert (found[[1, 7]] < 0.0).all()


def test_best_games_that_hit_nothing_do_not_set_the_scale() -> None:
    data = dataset([(), (1,), (1, 7), (1, 7, 2)], [()] * 4)
    model = train_reward_model(data, 3, NullProgress())
    levels = model.level(
        model.score_features(
            torch.cat([read(game(aliens).observations[-1:]) for aliens in ((), (1,))])
        )
    )
    assert levels[1] - levels[0] == pytest.approx(-1.0, abs=0.1)


def test_the_check_passes_a_ranking_and_stops_random_ones() -> None:
    data = dataset(COLUMN_3_RANKING, [COLUMN_3] * 3)
    model = train_reward_model(data, 1, NullProgress())
    check, model = check_ranking(model, data, 1, NullProgress())
    assert check.passed, check
    assert check.tau > 0.95
    assert model.spread is not None
    passed = []
    for seed in range(8):
        order = np.random.default_rng(seed).permutation(len(COLUMN_3_RANKING))
        shuffled = replace(data, tiers=tuple(data.tiers[index] for index in order))
        model = train_reward_model(shuffled, 1, NullProgress())
        passed.append(check_ranking(model, shuffled, 1, NullProgress())[0].passed)
    assert sum(passed) <= 1, passed


def test_the_same_training_seed_gives_the_same_labels() -> None:
    data = dataset(COLUMN_3_RANKING[4:])
    assert np.array_equal(labels(data), labels(data))
    assert not np.array_equal(labels(data), labels(data, seed=1))


def test_labels_and_order_are_read_off_a_network() -> None:
    rng = np.random.default_rng(3)
    network = pretrained_network(rng)
    expected, order = rng.uniform(-1, 1, 36), rng.uniform(0, 1, 36)
    order[::6] = 0.0
    set_labels(network, expected, order)
    found = labels_of(network)
    np.testing.assert_allclose(found[0], expected, atol=1e-6)
    np.testing.assert_allclose(found[1], order, atol=1e-4)


@pytest.mark.parametrize("report", [3, 16])
def test_it_can_be_cancelled_while_it_samples(report: int) -> None:
    with pytest.raises(RunCancelled):
        train_reward_model(dataset(COLUMN_3_RANKING), 7, RecordingProgress(cancel_at=report))


def test_progress_is_reported() -> None:
    progress = RecordingProgress()
    model = train_reward_model(
        replace(dataset(COLUMN_3_RANKING), recipe=replace(RECIPE, updates=5)), 7, progress
    )
    assert isinstance(model, RewardModel)
    assert progress.done[-5:] == [1, 2, 3, 4, 5]
