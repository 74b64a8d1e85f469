"""Recipes as runs store them."""

from __future__ import annotations

from dataclasses import fields
from typing import Any

from tril.errors import Invalid
from tril.recipes.values import (
    CloningRecipe,
    DaggerRecipe,
    EvaluationRecipe,
    GailRecipe,
    PolicyRecipe,
    Recipe,
    RewardRecipe,
)


def recipe_from_dict(data: dict[str, Any]) -> Recipe:
    """Rebuild a stored recipe.

    A run of an earlier version stays readable: values that this version does not know are left
    out, values that it adds are the ones of a recipe that says nothing of them.

    Raises:
        Invalid: It is no recipe.
    """
    try:
        return Recipe(
            **{
                **{key: value for key, value in data.items() if not isinstance(value, dict)},
                "reward": RewardRecipe(**_known(RewardRecipe, data["reward"])),
                "policy": PolicyRecipe(**_known(PolicyRecipe, data["policy"])),
                "cloning": CloningRecipe(**_known(CloningRecipe, data["cloning"])),
                "evaluation": EvaluationRecipe(**_known(EvaluationRecipe, data["evaluation"])),
                "dagger": DaggerRecipe(**_known(DaggerRecipe, data.get("dagger", {}))),
                "gail": GailRecipe(**_known(GailRecipe, data.get("gail", {}))),
            }
        )
    except (KeyError, TypeError) as error:
        raise Invalid(f"This is not a recipe of this version of Tril: {error}.") from error


def _known(part: type, values: dict[str, Any]) -> dict[str, Any]:
    """Return the values that a part of a recipe has, JSON's lists as tuples again."""
    names = {field.name for field in fields(part)}
    return {
        name: tuple(value) if isinstance(value, list) else value
        for name, value in values.items()
        if name in names
    }
