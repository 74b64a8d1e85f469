"""Attention maps against their definition."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pytest
import torch

from testsupport.space_invaders import evaluation_start
from trainer.explain.attention import (
    POSITIONS,
    attention_map,
    changes_at,
    changing_positions,
    pick_states,
    states_at,
)
from trainer.explain.gradient import gradient_map
from trainer.explain.occlusion import PATCH
from trainer.explain.patches import patch_map
from trainer.progress import NullProgress
from trainer.reward.model import RewardModel, RewardNetwork
from tril.games.space_invaders import SPACE_INVADERS
from tril.play.observation import AgentView


def _model() -> RewardModel:
    torch.manual_seed(7)
    return RewardModel(RewardNetwork(), 0.3, 0.05)


@pytest.fixture(scope="module")
def game_observation() -> npt.NDArray[np.uint8]:
    console = SPACE_INVADERS.make_console()
    console.start(evaluation_start(0))
    view = AgentView(SPACE_INVADERS)
    view.reset(console)
    for frame in range(1, 121):
        console.act(1 if frame % 3 else 2)
        view.update(console, frame)
    return np.array(view.observation)


def _occluded_changes(
    model: RewardModel,
    observation: npt.NDArray[np.uint8],
    positions: npt.NDArray[np.int64],
    background: int = 0,
) -> npt.NDArray[np.float32]:
    """|R(occluded) - R| by the definition: each occluded observation is scored as a whole."""
    occluded = np.repeat(observation[None], len(positions), axis=0)
    for target, (screen, row, column) in zip(occluded, positions, strict=True):
        target[screen, row : row + PATCH, column : column + PATCH] = background
    plain = model.score(observation[None])
    changes: npt.NDArray[np.float32] = np.abs(model.score(occluded) - plain)
    return changes


def test_the_map_equals_brute_force(game_observation: npt.NDArray[np.uint8]) -> None:
    model, screen = _model(), 2
    every = np.array([(screen, r, c) for r in range(POSITIONS) for c in range(POSITIONS)])
    expected = np.zeros((84, 84))
    changes = _occluded_changes(model, game_observation, every)
    for (_, row, column), change in zip(every, changes, strict=True):
        expected[row : row + PATCH, column : column + PATCH] += change
    assert expected.max() > 0
    found = attention_map(model, game_observation)[screen]
    np.testing.assert_allclose(found, expected, rtol=1e-3, atol=2e-4 * expected.max())


@pytest.mark.parametrize("background", [0, 107])
def test_patches_anywhere_change_what_occlusion_changes(background: int) -> None:
    model = _model()
    rng = np.random.default_rng(3)
    noise = rng.integers(0, 256, (4, 84, 84), dtype=np.uint8)
    edges = [
        (s, r, c) for s in range(4) for r in (0, 1, 5, 76, 78, 81) for c in (0, 2, 6, 77, 78, 81)
    ]
    positions = np.array([*edges, *rng.integers(0, (4, 82, 82), (200, 3)).tolist()])
    expected = _occluded_changes(model, noise, positions, background)
    changes = changes_at(model, noise, positions, NullProgress(), background)
    np.testing.assert_allclose(changes, expected, rtol=1e-3, atol=1e-2 * expected.max())


def test_the_gradients_map_is_the_change_per_pixel_where_r_is_linear(
    game_observation: npt.NDArray[np.uint8],
) -> None:
    model = _model()
    quick = gradient_map(model, game_observation)
    assert quick.shape == game_observation.shape
    assert not quick[game_observation == 0].any()
    rng = np.random.default_rng(0)
    dimmed = game_observation.astype(np.int16)
    lit = np.argwhere(game_observation > 1)
    places = tuple(lit[rng.integers(0, len(lit), 40)].T)
    for place in zip(*places, strict=True):
        one = dimmed.copy()
        one[place] -= 1
        change = abs(model.score(np.stack([one, dimmed]).astype(np.uint8)) @ [1.0, -1.0])
        per_pixel = change * game_observation[place]
        assert quick[place] == pytest.approx(per_pixel, abs=0.1 * float(quick.max()))


@pytest.mark.parametrize("background", [0, 107])
def test_an_empty_screen_has_no_attention(background: int) -> None:
    empty = np.full((4, 84, 84), background, np.uint8)
    model = _model()
    assert not attention_map(model, empty, background=background).any()
    assert not gradient_map(model, empty, background).any()
    assert not patch_map(model, empty, background=background).any()


def test_only_patches_that_change_something_are_tried() -> None:
    observation = np.zeros((4, 84, 84), np.uint8)
    observation[1, 40, 50] = 9
    positions = changing_positions(observation)
    assert sorted(map(tuple, positions.tolist())) == [
        (1, row, column) for row in (38, 39, 40) for column in (48, 49, 50)
    ]


def test_an_observation_of_another_shape_is_refused() -> None:
    with pytest.raises(ValueError, match="Expected an observation uint8"):
        attention_map(_model(), np.zeros((84, 84, 4), np.uint8))


def test_states_are_chosen_by_their_reward() -> None:
    rewards = [np.arange(0, 100, 2, dtype=np.float32), np.arange(1, 100, 2, dtype=np.float32)]
    picked = pick_states(rewards)
    assert [state.name for state in picked] == [
        "minimum",
        "90th percentile",
        "95th percentile",
        "maximum",
    ]
    assert [state.reward for state in picked] == [0.0, 89.0, 94.0, 99.0]
    every = states_at(rewards, [percentile / 100 for percentile in range(101)])
    assert [reward for _, _, reward in every[:3]] == [0.0, 1.0, 2.0]
    assert every[-1] == (1, 49, 99.0)
    for state in picked:
        assert rewards[state.trajectory][state.step] == state.reward
