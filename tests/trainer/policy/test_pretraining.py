"""Clones that begin with the policy that ships."""

from __future__ import annotations

import pytest
import torch

from tests.trainer.samples import planted_trajectories
from trainer.policy.cloning import train_clone
from trainer.policy.networks import pretrained_policy
from trainer.progress import NullProgress
from tril.errors import Invalid
from tril.recipes import ANY, FAST, CloningRecipe, changed_values, with_values


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


@pytest.mark.parametrize(
    "without", [{"policy.freeze_convolutions": False}, {"policy.network": "nature"}]
)
def test_a_mixed_start_has_the_convolutions_of_the_policy_that_ships(
    without: dict[str, object],
) -> None:
    with pytest.raises(Invalid, match="mixed_start=true needs freeze_convolutions=true"):
        with_values(ANY, without)
    assert not with_values(ANY, {"policy.mixed_start": False, **without}).policy.mixed_start


def test_a_mixed_start_is_judged_by_a_learned_reward() -> None:
    with pytest.raises(Invalid, match=r"set policy\.mixed_start=false"):
        with_values(ANY, {"method": "gail"})
    assert with_values(ANY, {"method": "gail", "policy.mixed_start": False}).method == "gail"


def test_a_mixed_start_holds_ppo_to_nothing() -> None:
    with pytest.raises(Invalid, match="mixed_start=true needs kl_coef=0"):
        with_values(ANY, {"policy.kl_coef": 0.03})
