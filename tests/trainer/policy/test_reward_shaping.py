import numpy as np
import pytest

from tests.trainer.samples import random_model
from trainer.policy.reward_shaping import RewardShaping

BEFORE = np.array([0.0, 1.0, -1.0], np.float32)
REACHED = np.array([2.0, 1.0, 0.0], np.float32)
DIED = np.array([False, False, True])


@pytest.mark.parametrize(
    ("kind", "expected"),
    [
        ("sigmoid", [0.880797, 0.731059, 0.5 - 3.0]),
        ("level", [0.75, 0.5, 0.25 - 3.0]),
        ("difference", [0.5, 0.0, 0.25 - 3.0]),
        ("softplus", [2.126928, 1.313262, 0.693147 - 3.0]),
    ],
)
def test_each_kind_has_its_shape(kind: str, expected: list[float]) -> None:
    shaping = RewardShaping(random_model(zero=-1.0, one=3.0), kind, 3.0)
    np.testing.assert_allclose(shaping.shape(BEFORE, REACHED, DIED), expected, rtol=1e-5)
    scaled = RewardShaping(shaping.model, kind, 3.0, 0.1).shape(BEFORE, REACHED, DIED)
    np.testing.assert_allclose(scaled, 0.1 * np.array(expected), rtol=1e-5)


def test_a_games_return_is_of_the_states_reached_and_its_death() -> None:
    rewards = np.array([9.0, 1.0, 3.0], np.float32)
    shaping = RewardShaping(random_model(zero=-1.0, one=3.0), "level", 2.0)
    assert shaping.shaped_return(rewards, False) == pytest.approx(1.5)
    assert shaping.shaped_return(rewards, True) == pytest.approx(-0.5)
    assert shaping.shaped_return(rewards, True) == pytest.approx(-0.5)


def test_what_was_reached_is_forfeited_at_death() -> None:
    shaping = RewardShaping(random_model(zero=0.0, one=2.0), "difference", 0.1, death_forfeit=0.5)
    progress = np.array([0.0, 1.0, 2.0, 2.0], np.float32)
    assert shaping.shaped_return(progress, False) == pytest.approx(1.0)
    assert shaping.shaped_return(progress, True) == pytest.approx(1.0 - 0.1 - 0.5)
    # Below the beginning's level there is nothing to forfeit.
    assert shaping.shaped_return(-progress, True) == pytest.approx(-1.0 - 0.1)


def test_differences_add_up_to_the_gain_of_the_whole_game() -> None:
    rewards = np.random.default_rng(0).normal(size=50).astype(np.float32)
    shaping = RewardShaping(random_model(zero=0.0, one=2.0), "difference", 0.0)
    gain = (rewards[-1] - rewards[0]) / 2.0
    assert shaping.shaped_return(rewards, False) == pytest.approx(gain, abs=1e-5)
