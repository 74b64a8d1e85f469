"""Attention maps of policies, and by larger patches, against their definitions."""

from __future__ import annotations

import numpy as np
import pytest
import torch

from trainer.explain.attention import attention_map
from trainer.explain.gradient import gradient_map
from trainer.explain.patches import patch_map
from trainer.explain.subject import ActionOdds
from trainer.policy.networks import Policy, new_policy
from tril.games.space_invaders.memory import Action
from tril.play.observation import Observation


@pytest.fixture(scope="module")
def policy() -> Policy:
    return Policy(new_policy("small", 6, 0.0, np.random.default_rng(5)))


@pytest.fixture
def observation() -> Observation:
    observation = np.zeros((4, 84, 84), np.uint8)
    drawn = np.random.default_rng(0).integers(1, 256, (4, 6, 6), np.uint8)
    observation[:, 40:46, 30:36] = drawn
    return observation


def test_odds_are_those_of_the_most_likely_action(policy: Policy, observation: Observation) -> None:
    subject = ActionOdds.of_choice(policy, observation)
    (probabilities,) = policy.probabilities(observation[None]).astype(np.float64)
    assert subject.action == Action(int(probabilities.argmax()))
    p = probabilities.max()
    assert subject.score(observation[None])[0] == pytest.approx(np.log(p / (1 - p)), abs=1e-4)


def test_a_policys_map_is_the_change_of_the_odds_under_each_patch(
    policy: Policy, observation: Observation
) -> None:
    subject = ActionOdds.of_choice(policy, observation)
    expected = np.zeros((4, 84, 84))
    plain = subject.score(observation[None])[0]
    for screen, row, column in np.ndindex(4, 8, 8):
        occluded = observation.copy()
        where = (screen, slice(38 + row, 41 + row), slice(28 + column, 31 + column))
        occluded[where] = 0
        expected[where] += abs(subject.score(occluded[None])[0] - plain)
    found = attention_map(subject, observation)
    np.testing.assert_allclose(found, expected, atol=1e-5)
    assert found.max() > 0


def test_a_policys_gradient_estimates_the_change_of_one_pixel(
    policy: Policy, observation: Observation
) -> None:
    subject = ActionOdds.of_choice(policy, observation)
    pixels = torch.from_numpy(observation[None].astype(np.float32))
    less = pixels.clone()
    less[0, 3, 42, 33] *= 0.99
    change = (subject.of_pixels(pixels) - subject.of_pixels(less)).abs().item() / 0.01
    assert gradient_map(subject, observation)[3, 42, 33] == pytest.approx(change, rel=0.05)


def test_patches_hide_all_screens_at_once(policy: Policy, observation: Observation) -> None:
    subject = ActionOdds.of_choice(policy, observation)
    found = patch_map(subject, observation, side=42, stride=42)
    plain = subject.score(observation[None])[0]
    hidden = observation.copy()
    hidden[:, :42, :42] = 0
    expected = abs(subject.score(hidden[None])[0] - plain)
    np.testing.assert_allclose(found[:42, :42], expected, rtol=1e-4)
    # Where a patch hides nothing, nothing changes.
    assert not found[:, 42:].any()
