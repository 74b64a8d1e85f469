"""Recipes made from others."""

from __future__ import annotations

from dataclasses import fields, is_dataclass, replace
from typing import Any

from tril.errors import Invalid
from tril.recipes.values import EvaluationRecipe, Recipe

FOR_PEOPLE = ("name", "summary", "default_steps")
"""Values of a recipe that change nothing of what is learned."""


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


def changed_values(recipe: Recipe, original: Recipe) -> dict[str, Any]:
    """Return by dotted path what with_values makes the recipe of the original with.

    What is for people, name, summary and default steps, doesn't count.
    """
    changed: dict[str, Any] = {}
    for field in fields(recipe):
        if field.name in FOR_PEOPLE:
            continue
        value, other = getattr(recipe, field.name), getattr(original, field.name)
        if is_dataclass(value):
            for inner in fields(value):
                if getattr(value, inner.name) != getattr(other, inner.name):
                    changed[f"{field.name}.{inner.name}"] = getattr(value, inner.name)
        elif value != other:
            changed[field.name] = value
    return changed
