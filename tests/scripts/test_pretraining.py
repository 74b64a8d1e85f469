"""Networks that learn to read screens off varied play, and to survive."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import torch

from scripts.pretraining import policy as pretraining
from scripts.pretraining.foresight import N_OUTCOMES
from scripts.pretraining.memory_reading import Screens, play_games
from scripts.pretraining.policy import (
    NoReward,
    death_rate,
    pretrain_survival,
    pretrain_vision,
)
from scripts.pretraining.reward import pretrain
from trainer.nn.checkpoints import load_tensors
from trainer.policy.networks import PRETRAINED, new_policy, pretrained_policy
from trainer.policy.reward_shaping import RewardShaping
from tril.demonstrators import play_varied
from tril.recipes import with_values

ALIENS_LEFT = 17 * 8
"""First bit of the number of aliens left, see space_invaders."""

N_GAMES = 5


@pytest.fixture(scope="module")
def screens() -> Screens:
    return play_games(N_GAMES, seed=5, n_processes=1)


def test_screens_belong_to_the_memory_beside_them(screens: Screens) -> None:
    assert screens.observations.shape == (len(screens.bits), 4, 84, 84)
    assert screens.bits.shape[1] == 1024
    assert np.unique(screens.games).tolist() == list(range(N_GAMES))
    again = play_games(N_GAMES, seed=5, n_processes=1)
    assert np.array_equal(again.bits, screens.bits)
    assert np.array_equal(again.observations, screens.observations)
    # The memory counts the aliens, too.
    n_left = np.packbits(screens.bits[:, ALIENS_LEFT : ALIENS_LEFT + 8], axis=1)[:, 0]
    assert (screens.standing.sum(1) == n_left).all()
    for game in range(N_GAMES):
        standing = screens.standing[screens.games == game].astype(int)
        assert (np.diff(standing, axis=0) <= 0).all()


def test_pretraining_learns_what_is_on_the_screen(screens: Screens) -> None:
    network, figures = pretrain(screens, seed=0)
    assert figures["aliens"]["n_flags"] == 36
    assert network.output.in_features == 36 + 30
    assert 0.5 < figures["aliens"]["accuracy"] <= 1.0
    assert figures["aliens"]["known"] < 1.0


def test_games_are_put_together(screens: Screens) -> None:
    both = screens.with_games(screens)
    assert np.unique(both.games).tolist() == list(range(2 * N_GAMES))
    n_states = len(screens.games)
    assert np.array_equal(both.games[n_states:], screens.games + N_GAMES)
    assert np.array_equal(both.observations[n_states:], screens.observations)
    assert len(both.bits) == len(both.outcomes) == len(both.standing) == 2 * n_states


def test_it_learns_to_see_and_then_to_survive(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    short = {"policy.n_envs": 2, "policy.n_steps": 64, "policy.snapshot_episodes": 1}
    monkeypatch.setattr(pretraining, "RECIPE", with_values(pretraining.RECIPE, short))
    screens = play_games(5, seed=5, n_processes=1, look_ahead=True)
    policy, figures = pretrain_vision(screens, seed=0)
    assert figures["bits"]["n_flags"] == len(screens.varying())
    assert figures["hits"]["n_flags"] + figures["shots"]["n_flags"] == N_OUTCOMES
    assert 0.5 < figures["bits"]["accuracy"] <= 1.0
    games = [play_varied(np.random.default_rng(0)).recording]
    # Two rollouts: the learning rate is zero in the last one.
    survivor = pretrain_survival(policy, games, 256, seed=0, folder=tmp_path)
    before, after = policy.state_dict(), survivor.state_dict()
    assert {name: one.shape for name, one in before.items()} == {
        name: one.shape for name, one in after.items()
    }
    assert not torch.equal(before["action_net.weight"], after["action_net.weight"])


def test_only_being_hit_counts() -> None:
    model = NoReward.new()
    observations = np.random.default_rng(0).integers(0, 256, (3, 4, 84, 84), np.uint8)
    rewards = model.score(observations)
    shaping = RewardShaping(model, "difference", death_penalty=1.0)
    died = np.array([False, True, False])
    assert shaping.shape(rewards, rewards, died).tolist() == [0.0, -1.0, 0.0]


def test_the_policy_that_ships_survives(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(pretraining, "EVALUATION_START_COUNT", 8)
    _, metadata = load_tensors(PRETRAINED)
    assert "figures" in metadata
    untrained = new_policy("small", 6, 0.0, np.random.default_rng(0))
    assert death_rate(pretrained_policy(0.0)) < 0.5 < death_rate(untrained)
