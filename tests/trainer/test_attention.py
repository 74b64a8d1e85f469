"""Attention maps against their definition."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pytest
import torch

from trainer.attention import (
    PATCH,
    POSITIONS,
    attention_map,
    changing_positions,
    pick_states,
)
from trainer.reward.model import RewardModel, RewardNetwork
from tril.game.console import Console
from tril.game.observation import AgentView
from tril.game.starts import evaluation_start


def _model(n_members: int) -> RewardModel:
    torch.manual_seed(7)
    members = tuple(RewardNetwork() for _ in range(n_members))
    return RewardModel(members, (0.3,) * n_members, (0.05,) * n_members)


@pytest.fixture(scope="module")
def game_observation() -> npt.NDArray[np.uint8]:
    console = Console()
    console.start(evaluation_start(0))
    view = AgentView()
    view.begin(console)
    for frame in range(1, 121):
        console.act(1 if frame % 3 else 2)
        view.watch(console, frame)
    return np.array(view.observation)


def _brute_force(
    model: RewardModel, observation: npt.NDArray[np.uint8], screen: int
) -> npt.NDArray[np.float64]:
    """One screen's map by the definition, every position tried and every pixel added to."""
    masked = np.repeat(observation[None], POSITIONS * POSITIONS, axis=0)
    for row in range(POSITIONS):
        for column in range(POSITIONS):
            target = masked[row * POSITIONS + column, screen]
            target[row : row + PATCH, column : column + PATCH] = 0
    changes = np.abs(model.score(masked) - model.score(observation[None]))
    result = np.zeros((84, 84))
    for row in range(POSITIONS):
        for column in range(POSITIONS):
            result[row : row + PATCH, column : column + PATCH] += changes[row * POSITIONS + column]
    return result


@pytest.mark.parametrize(("n_members", "screen"), [(1, 0), (1, 3), (2, 1)])
def test_the_map_equals_brute_force(
    game_observation: npt.NDArray[np.uint8], n_members: int, screen: int
) -> None:
    model = _model(n_members)
    expected = _brute_force(model, game_observation, screen)
    found = attention_map(model, game_observation)[screen]
    assert expected.max() > 0
    np.testing.assert_allclose(found, expected, rtol=1e-3, atol=2e-4 * expected.max())


def test_patches_at_every_edge_equal_brute_force() -> None:
    model = _model(1)
    noise = np.random.default_rng(3).integers(0, 256, (4, 84, 84), dtype=np.uint8)
    found = attention_map(model, noise)[2]
    expected = _brute_force(model, noise, 2)
    np.testing.assert_allclose(found, expected, rtol=1e-3, atol=2e-4 * expected.max())


def test_an_empty_screen_has_no_attention() -> None:
    assert not attention_map(_model(1), np.zeros((4, 84, 84), np.uint8)).any()


def test_only_patches_that_change_something_are_tried() -> None:
    observation = np.zeros((4, 84, 84), np.uint8)
    observation[1, 40, 50] = 9
    positions = changing_positions(observation)
    assert sorted(map(tuple, positions.tolist())) == [
        (1, row, column) for row in (38, 39, 40) for column in (48, 49, 50)
    ]


def test_an_observation_of_another_shape_is_refused() -> None:
    with pytest.raises(ValueError, match="Expected an observation uint8"):
        attention_map(_model(1), np.zeros((84, 84, 4), np.uint8))


def test_states_are_picked_by_their_reward() -> None:
    rewards = [np.arange(0, 100, 2, dtype=np.float32), np.arange(1, 100, 2, dtype=np.float32)]
    picked = pick_states(rewards)
    assert [state.name for state in picked] == [
        "minimum",
        "90th percentile",
        "95th percentile",
        "maximum",
    ]
    assert [state.reward for state in picked] == [0.0, 89.0, 94.0, 99.0]
    for state in picked:
        assert rewards[state.trajectory][state.step] == state.reward
