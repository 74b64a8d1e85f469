from collections.abc import Sequence

import numpy as np
import pytest

from tests.trainer.samples import TIERS, planted_trajectories, planted_trajectory
from trainer.reward.preference_dataset import PerfectDemonstrations, PreferenceDataset
from tril.recipes import FAST, PAPER

TRAJECTORIES = planted_trajectories()

make = PreferenceDataset.from_demonstrations


@pytest.fixture(scope="module")
def perfect() -> PerfectDemonstrations:
    """Two perfect games, the second of them ranked second."""
    free = planted_trajectory(np.random.default_rng(8), 5, 40)
    return PerfectDemonstrations([free, TRAJECTORIES[1]], [None, 1])


@pytest.mark.parametrize(
    ("held_out", "tiers", "found"),
    [
        ((), ((0,), (1,), (2, 3), (4,), (5,)), (6, 1)),
        ((1, 3), ((0,), (2,), (4,), (5,)), (6,)),
        ((0, 6), ((1,), (2, 3), (4,), (5,)), (1,)),
    ],
)
def test_what_is_held_out_is_held_out_everywhere(
    perfect: PerfectDemonstrations,
    held_out: Sequence[int],
    tiers: tuple[tuple[int, ...], ...],
    found: tuple[int, ...],
) -> None:
    dataset = make(TRAJECTORIES, TIERS, FAST.reward, perfect).without(held_out)
    assert (dataset.tiers, dataset.perfect) == (tiers, found)
    assert not set(held_out) & {index for pair in dataset.pairs for index in pair}


def test_the_best_are_the_first_tier_and_perfect_games_that_are_not_ranked(
    perfect: PerfectDemonstrations,
) -> None:
    assert make(TRAJECTORIES, TIERS, FAST.reward, perfect).best == (0, 6)


def test_the_published_method_learns_from_the_ranking_alone(
    perfect: PerfectDemonstrations,
) -> None:
    dataset = make(TRAJECTORIES, TIERS, PAPER.reward, perfect)
    assert (dataset.perfect, len(dataset.trajectories)) == ((), 6)
    assert dataset.best == (0,)
