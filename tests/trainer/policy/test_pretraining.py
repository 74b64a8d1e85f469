"""A policy that has learned to see and to survive, and clones that begin with it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import torch

from tests.trainer.samples import planted_trajectories
from trainer.games.space_invaders.foresight import N_OUTCOMES
from trainer.games.space_invaders.memory_reading import play_games
from trainer.nn.checkpoints import load_tensors
from trainer.policy import pretraining
from trainer.policy.cloning import train_clone
from trainer.policy.networks import PRETRAINED, new_policy, pretrained_policy
from trainer.policy.pretraining import (
    NoReward,
    death_rate,
    pretrain_survival,
    pretrain_vision,
)
from trainer.policy.reward_shaping import RewardShaping
from trainer.progress import NullProgress
from tril.demonstrators import play_varied
from tril.errors import Invalid
from tril.recipes import FAST, CloningRecipe, changed_values, with_values


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


def test_a_pretrained_clone_begins_with_it() -> None:
    recipe = CloningRecipe(network="small", pretrained=True, epochs=1, learning_rate=1e-12)
    clone, _ = train_clone(planted_trajectories(), 6, recipe, 0, NullProgress())
    shipped = pretrained_policy(0.0).state_dict()
    for name, weight in clone.state_dict().items():
        assert torch.allclose(weight, shipped[name], atol=1e-6), name


@pytest.mark.parametrize("frozen", [False, True])
def test_a_clone_may_keep_how_the_game_looks(frozen: bool) -> None:
    recipe = CloningRecipe(network="small", pretrained=True, epochs=1, freeze_convolutions=frozen)
    clone, _ = train_clone(planted_trajectories(), 6, recipe, 0, NullProgress())
    shipped = pretrained_policy(0.0).state_dict()
    changed = {
        name for name, one in clone.state_dict().items() if not torch.equal(one, shipped[name])
    }
    assert any(".cnn." in name for name in changed) is not frozen
    assert "action_net.weight" in changed


@pytest.mark.parametrize(("part", "needed"), [("cloning", "pretrained"), ("policy", "warm_start")])
def test_convolutions_are_frozen_only_where_they_have_learned(part: str, needed: str) -> None:
    without = {f"{part}.{needed}": False}
    said = f"{part}: .* needs {needed}=true.*: set it, or freeze_convolutions=false"
    with pytest.raises(Invalid, match=said):
        with_values(FAST, {**without, f"{part}.freeze_convolutions": True})
    thawed = {**without, f"{part}.freeze_convolutions": False}
    assert changed_values(with_values(FAST, thawed), FAST) == thawed


def test_a_pretrained_clone_has_the_size_of_the_policy_that_ships() -> None:
    with pytest.raises(Invalid, match="a pretrained clone has the network 'small'"):
        with_values(FAST, {"cloning.pretrained": True, "cloning.network": "nature"})
    assert with_values(FAST, {"cloning.pretrained": "true"}).cloning.pretrained
