import numpy as np
import pytest

from tests.trainer.policy.made_up import random_model
from trainer.policy.reward_shaping import RewardShaping
from tril.game.episode import EndReason

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
def test_each_kind_pays_what_it_says(kind: str, expected: list[float]) -> None:
    payment = RewardShaping(random_model(zero=-1.0, one=3.0), kind, 3.0)
    np.testing.assert_allclose(payment.pay(BEFORE, REACHED, DIED), expected, rtol=1e-5)
    scaled = RewardShaping(payment.model, kind, 3.0, 0.1).pay(BEFORE, REACHED, DIED)
    np.testing.assert_allclose(scaled, 0.1 * np.array(expected), rtol=1e-5)


def test_a_game_is_paid_for_the_states_reached_and_its_death() -> None:
    states = np.array([9.0, 1.0, 3.0], np.float32)
    payment = RewardShaping(random_model(zero=-1.0, one=3.0), "level", 2.0)
    assert payment.total(states, EndReason.STEPS) == pytest.approx(1.5)
    assert payment.total(states, EndReason.HIT) == pytest.approx(-0.5)
    assert payment.total(states, EndReason.LIVES) == pytest.approx(-0.5)


def test_differences_add_up_to_the_gain_of_the_whole_game() -> None:
    states = np.random.default_rng(0).normal(size=50).astype(np.float32)
    payment = RewardShaping(random_model(zero=0.0, one=2.0), "difference", 0.0)
    gain = (states[-1] - states[0]) / 2.0
    assert payment.total(states, EndReason.STEPS) == pytest.approx(gain, abs=1e-5)
