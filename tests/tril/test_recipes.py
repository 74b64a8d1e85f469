"""Recipes as data."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from operator import attrgetter
from typing import Any

import pytest

from tril.errors import Invalid
from tril.games.space_invaders.ends import Ending
from tril.recipes import (
    FAST,
    FORMER_NAMES,
    PAPER,
    RECIPES,
    Recipe,
    changed_values,
    checked,
    recipe_from_dict,
    recipe_named,
    with_values,
)


@pytest.mark.parametrize("recipe", RECIPES.values(), ids=RECIPES)
def test_a_built_in_recipe_is_valid_and_survives_being_stored(recipe: Recipe) -> None:
    assert with_values(recipe, {}) == recipe
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
    for name in ("method", "gail"):
        del stored[name]
    assert recipe_from_dict(stored) == FAST


def test_a_stored_value_that_would_be_refused_today_stays_readable() -> None:
    stored = FAST.to_dict()
    stored["policy"]["n_epochs"] = "abc"
    assert recipe_from_dict(stored).to_dict() == stored


@pytest.mark.parametrize("data", [{"name": "fast"}, {**FAST.to_dict(), "policy": 3}])
def test_what_is_no_recipe_is_refused(data: dict[str, Any]) -> None:
    with pytest.raises(Invalid, match="not a recipe"):
        recipe_from_dict(data)


@pytest.mark.parametrize("ending", Ending)
def test_a_recipe_can_have_every_ending(ending: Ending) -> None:
    assert Ending(with_values(FAST, {"ending": str(ending)}).ending) is ending


def test_a_recipe_may_propose_more_steps_for_aliens_in_order() -> None:
    recipe = replace(FAST, default_steps=5, ordered_steps=7)
    assert recipe.proposed_steps(ordered=False) == 5
    assert recipe.proposed_steps(ordered=True) == 7
    assert replace(recipe, ordered_steps=0).proposed_steps(ordered=True) == 5


def test_values_are_replaced_by_their_path() -> None:
    changed = with_values(FAST, {"policy.learning_rate": 0.5, "default_steps": 7})
    assert (changed.policy.learning_rate, changed.default_steps) == (0.5, 7)
    assert changed.reward == FAST.reward


def test_text_is_read_as_the_values_type() -> None:
    text = {
        "method": "gail",
        "ending": "life_counter",
        "policy.n_epochs": "3",
        "policy.gamma": "1",
        "policy.warm_start": "false",
        "policy.freeze_convolutions": "false",
        "policy.snapshot_steps": "100,2000",
        "policy.own_starts": "31",
        "evaluation.further_start_numbers": "",
    }
    read = with_values(FAST, text)
    assert changed_values(read, FAST) == {
        "method": "gail",
        "ending": "life_counter",
        "policy.n_epochs": 3,
        "policy.gamma": 1.0,
        "policy.warm_start": False,
        "policy.freeze_convolutions": False,
        "policy.snapshot_steps": (100, 2000),
        "policy.own_starts": (31,),
        "evaluation.further_start_numbers": (),
    }


@pytest.mark.parametrize(
    ("path", "value", "said"),
    [
        ("policy.n_epochs", "abc", "must be a whole number from 1 to .*, got 'abc'"),
        ("policy.n_steps", 2.5, "must be a whole number from 1 to .*, got 2.5"),
        ("policy.n_envs", "0", "must be a whole number from 1 to .*, got '0'"),
        ("policy.gamma", 2, "must be a number from 0 to 1, got 2"),
        ("policy.gamma", "nan", "must be a number from 0 to 1, got 'nan'"),
        ("policy.learning_rate", "0", "must be a number above 0, got '0'"),
        ("reward.learning_rate", "inf", "must be a number above 0, got 'inf'"),
        ("reward.folds", -1, "must be a whole number from 0 to .*, got -1"),
        ("policy.death_penalty", "-1", "must be a number, at least 0, got '-1'"),
        ("policy.warm_start", "maybe", "must be true or false, got 'maybe'"),
        ("policy.snapshot_steps", "1,0", "must be whole numbers .*, each at least 1, .* got '0'"),
        ("evaluation.start_numbers", "32", "must be numbers from 0 to 31 .*, got '32'"),
        ("method", "magic", "must be 'ppo' or 'gail', got 'magic'"),
        ("ending", "never", "must be 'hit' or 'life_counter', got 'never'"),
    ],
)
def test_an_impossible_value_is_refused_with_its_range(path: str, value: object, said: str) -> None:
    with pytest.raises(Invalid, match=rf"^{path} {said}\.$"):
        with_values(FAST, {path: value})


def test_values_that_do_not_go_together_are_refused() -> None:
    with pytest.raises(
        Invalid, match=r"n_minibatches must not be more than half of n_envs \* n_steps"
    ):
        with_values(FAST, {"policy.n_envs": 1, "policy.n_steps": 4})


@pytest.mark.parametrize(
    ("path", "said"),
    [
        ("policy.n_epoch", "Did you mean 'policy.n_epochs'?"),
        ("n_epochs", "Did you mean 'policy.n_epochs'?"),
        ("policy.entropy", "It is called 'policy.ent_coef' now."),
        ("policy", "no value 'policy'"),
        ("xyzzy", "no value 'xyzzy'."),
    ],
)
def test_an_unknown_value_is_refused_with_a_suggestion(path: str, said: str) -> None:
    with pytest.raises(Invalid, match=re.escape(said)):
        with_values(FAST, {path: 1})


def test_former_names_are_followed_by_todays() -> None:
    for former, today in FORMER_NAMES.items():
        assert attrgetter(today)(FAST) is not None
        with pytest.raises(AttributeError):
            attrgetter(former)(FAST)


def test_what_was_replaced_is_found_again() -> None:
    values = {"policy.learning_rate": 0.5, "reward.aligned": False, "method": "gail"}
    assert changed_values(with_values(FAST, values), FAST) == values
    assert changed_values(with_values(FAST, {"name": "other", "default_steps": 7}), FAST) == {}


def test_an_unknown_recipe_names_those_there_are() -> None:
    with pytest.raises(Invalid, match="fast, any, paper, gail"):
        recipe_named("slow")


def test_a_recipe_of_an_earlier_version_keeps_how_it_learned() -> None:
    former = recipe_from_dict(
        FAST.to_dict() | {"method": "dagger", "reward": {"method": "fast", "updates": 300}}
    )
    assert checked(former) == former
    for part_of_today in (replace(former, method="ppo"), replace(former, reward=FAST.reward)):
        assert checked(part_of_today) == part_of_today
    assert checked(FAST) == FAST
    unknown = replace(former, reward=replace(former.reward, method="magic"))  # type: ignore[arg-type]
    with pytest.raises(Invalid, match=r"reward\.method must be"):
        checked(unknown)
    wrong = replace(former, policy=replace(former.policy, n_epochs=0))
    with pytest.raises(Invalid, match=r"policy\.n_epochs must be"):
        checked(wrong)
