"""The deletion and insertion tests, on subjects whose important pixels are known."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pytest
from torch import Tensor

from trainer.explain.faithfulness import (
    POINTS,
    differences,
    measure_faithfulness,
    occupied_pixels,
    order_of,
)
from tril.play.observation import Observation, Observations

BLOCK = (slice(10, 14), slice(20, 24))
WHOLE = 16 * 4 * 100


class SumOfBlock:
    """A subject that looks at 16 of the pixels only."""

    def score(self, observations: Observations) -> npt.NDArray[np.float32]:
        return np.asarray(observations[:, :, *BLOCK].sum((1, 2, 3)), np.float32)

    def of_pixels(self, pixels: Tensor) -> Tensor:
        return pixels[:, :, *BLOCK].sum((1, 2, 3))


@pytest.fixture
def observation() -> Observation:
    observation = np.zeros((4, 84, 84), np.uint8)
    observation[:, 10:30, 20:28] = 100
    return observation


def the_true_map() -> npt.NDArray[np.float32]:
    values = np.zeros((84, 84), np.float32)
    values[BLOCK] = 1.0
    return values


def test_differences_go_from_nothing_to_the_whole_change(observation: Observation) -> None:
    order = order_of(the_true_map(), occupied_pixels(observation))
    deleted = differences(SumOfBlock(), observation, order, insert=False)
    inserted = differences(SumOfBlock(), observation, order, insert=True)
    assert deleted.shape == (POINTS + 1,)
    assert (deleted[0], deleted[-1]) == (0.0, WHOLE)
    assert (inserted[0], inserted[-1]) == (WHOLE, 0.0)
    # A tenth of the 160 pixels is all that matters.
    assert deleted[POINTS // 10] == WHOLE
    assert inserted[POINTS // 10] == 0.0


def test_a_true_map_beats_random_orders_and_a_false_one_does_not(observation: Observation) -> None:
    rng = np.random.default_rng(0)
    true = measure_faithfulness(SumOfBlock(), observation, the_true_map(), WHOLE, rng)
    assert true is not None
    assert true.map.hidden_fifth == 1.0
    assert true.random.hidden_fifth == pytest.approx(0.2, abs=0.15)
    assert true.map.deletion > true.random.deletion + 0.3
    assert true.map.insertion < true.random.insertion - 0.3
    false = measure_faithfulness(SumOfBlock(), observation, -the_true_map(), WHOLE, rng)
    assert false is not None
    assert false.map.hidden_fifth == 0.0
    assert false.map.deletion < false.random.deletion < true.map.deletion


@pytest.mark.parametrize("background", [0, 107])
def test_empty_screens_have_no_measure(background: int) -> None:
    observation = np.full((4, 84, 84), background, np.uint8)
    rng = np.random.default_rng(0)
    subject, values = SumOfBlock(), the_true_map()
    assert measure_faithfulness(subject, observation, values, WHOLE, rng, background) is None
