"""Recipes made from others."""

from __future__ import annotations

from dataclasses import fields, is_dataclass, replace
from typing import Any

from tril.errors import Invalid
from tril.recipes.values import EvaluationRecipe, Recipe


def judged_where_trained(recipe: Recipe, start_number: int) -> Recipe:
    """Return the recipe under the published protocol, which holds nothing out.

    The published work trains a policy of its own for each start and judges it on the very start
    (thesis, section 6.1): what is shown is how well that one game was learned.

    Raises:
        Invalid: The policy is not one that PPO trains.
    """
    if recipe.method == "dagger":
        raise Invalid("DAgger has no games of PPO that could begin at the start it is judged on.")
    return replace(
        recipe,
        policy=replace(recipe.policy, own_starts=(start_number,)),
        evaluation=EvaluationRecipe((start_number,), ()),
    )


def with_values(recipe: Recipe, values: dict[str, Any]) -> Recipe:
    """A copy with some values replaced, named by dotted path such as ``policy.learning_rate``."""
    for path, value in values.items():
        section, _, name = path.rpartition(".")
        part = getattr(recipe, section, None) if section else recipe
        if not is_dataclass(part) or name not in {f.name for f in fields(part)}:
            raise Invalid(f"A recipe has no value {path!r}.")
        changed = replace(part, **{name: value})  # type: ignore[type-var]
        recipe = replace(recipe, **{section: changed}) if section else changed  # type: ignore[arg-type, assignment]
    return recipe
