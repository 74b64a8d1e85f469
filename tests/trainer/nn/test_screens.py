"""Observations in the order in which networks read them."""

from __future__ import annotations

import numpy as np
import pytest
import torch

from trainer.nn.screens import channels_last_screens, take_screens
from tril.play.observation import check_observations


@pytest.fixture
def observations() -> np.ndarray:
    return np.random.default_rng(5).integers(0, 256, (6, 4, 84, 84), dtype=np.uint8)


def is_channels_last(screens: torch.Tensor) -> bool:
    return screens.permute(0, 2, 3, 1).is_contiguous()


def test_the_values_stay_and_their_order_in_memory_changes(observations: np.ndarray) -> None:
    screens = channels_last_screens(observations)
    assert np.array_equal(screens.numpy(), observations)
    assert is_channels_last(screens)
    for strided in (observations[::2], screens.numpy()[::2], screens.numpy()[::-1]):
        assert np.array_equal(channels_last_screens(strided).numpy(), strided)


def test_they_are_written_where_they_are_wanted(observations: np.ndarray) -> None:
    memory = np.zeros((6, 84, 84, 4), np.uint8)
    channels_last_screens(observations, memory)
    assert np.array_equal(memory, observations.transpose(0, 2, 3, 1))
    again = np.zeros_like(memory)
    channels_last_screens(channels_last_screens(observations).numpy(), again)
    assert np.array_equal(again, memory)


def test_what_is_in_that_order_is_not_copied(observations: np.ndarray) -> None:
    once = channels_last_screens(observations)
    again = channels_last_screens(once.numpy())
    assert again.data_ptr() == once.data_ptr()
    assert channels_last_screens(once.numpy()[2:4]).data_ptr() == once[2:4].data_ptr()


def test_some_of_them_keep_the_order(observations: np.ndarray) -> None:
    taken = take_screens(channels_last_screens(observations), torch.tensor([4, 0, 4]))
    assert np.array_equal(taken.numpy(), observations[[4, 0, 4]])
    assert is_channels_last(taken)


@pytest.mark.parametrize(
    "wrong", [np.zeros((2, 84, 84, 4), np.uint8), np.zeros((2, 4, 84, 84), np.float32)]
)
def test_what_is_no_observation_is_refused(wrong: np.ndarray) -> None:
    with pytest.raises(ValueError, match=r"Expected observations uint8 \(N, 4, 84, 84\)"):
        check_observations(wrong)
