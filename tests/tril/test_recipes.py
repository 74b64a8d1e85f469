"""Recipes as data."""

from __future__ import annotations

import json
from operator import attrgetter

import pytest

from tril.errors import Invalid
from tril.recipes import (
    ABLATIONS,
    FAST,
    PAPER,
    RECIPES,
    Ablation,
    Recipe,
    changed_values,
    recipe_from_dict,
    recipe_named,
    with_values,
)


@pytest.mark.parametrize("recipe", RECIPES.values(), ids=RECIPES)
def test_a_recipe_survives_being_stored(recipe: Recipe) -> None:
    assert recipe_from_dict(json.loads(json.dumps(recipe.to_dict()))) == recipe


def test_a_recipe_of_another_version_stays_readable() -> None:
    stored = FAST.to_dict()
    stored["policy"]["a_value_of_old"] = 3
    del stored["policy"]["reward_scale"]
    read = recipe_from_dict(stored)
    assert read.policy.reward_scale == PAPER.policy.reward_scale
    assert read.reward == FAST.reward


def test_a_recipe_from_before_there_were_methods_is_ppos() -> None:
    stored = FAST.to_dict()
    for name in ("method", "dagger", "gail"):
        del stored[name]
    assert recipe_from_dict(stored) == FAST


def test_the_method_is_a_value_like_others() -> None:
    assert with_values(FAST, {"method": "dagger", "dagger.expert_decay": 0}).method == "dagger"
    with pytest.raises(Invalid, match="no method 'magic'; choose one of ppo, dagger, gail"):
        with_values(FAST, {"method": "magic"})


def test_what_is_no_recipe_is_refused() -> None:
    with pytest.raises(Invalid, match="not a recipe"):
        recipe_from_dict({"name": "fast"})


def test_values_are_replaced_by_their_path() -> None:
    changed = with_values(FAST, {"policy.learning_rate": 0.5, "default_steps": 7})
    assert (changed.policy.learning_rate, changed.default_steps) == (0.5, 7)
    assert changed.reward == FAST.reward
    with pytest.raises(Invalid, match=r"no value 'policy\.nothing'"):
        with_values(FAST, {"policy.nothing": 1})


def test_what_was_replaced_is_found_again() -> None:
    values = {"policy.learning_rate": 0.5, "reward.aligned": False, "method": "gail"}
    assert changed_values(with_values(FAST, values), FAST) == values
    assert changed_values(with_values(FAST, {"name": "other", "default_steps": 7}), FAST) == {}


def test_an_unknown_recipe_names_those_there_are() -> None:
    with pytest.raises(Invalid, match="fast, paper, dagger, gail"):
        recipe_named("slow")


@pytest.mark.parametrize("one", ABLATIONS, ids=[one.name for one in ABLATIONS])
def test_an_ablation_changes_what_it_says_and_nothing_else(one: Ablation) -> None:
    for path, value in one.values.items():
        before, after = (attrgetter(path)(recipe) for recipe in (FAST, one.recipe))
        assert before != after == value
    restored = {path: attrgetter(path)(FAST) for path in one.values}
    assert with_values(one.recipe, restored) == FAST
