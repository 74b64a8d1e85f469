"""Recipes made from other recipes, from text and from stored data."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields, is_dataclass, replace
from difflib import get_close_matches
from functools import cache
from typing import Any, TypeVar, get_args, get_type_hints

from pydantic import TypeAdapter, ValidationError
from pydantic.fields import FieldInfo
from pydantic_core import ErrorDetails

from tril.errors import Invalid
from tril.recipes.values import EvaluationRecipe, Recipe

T = TypeVar("T")

MAX_PROBLEMS = 4
"""Most refused values that a refusal names."""

FORMER_METHODS = {"method": ("dagger", "ppo"), "reward.method": ("fast", "paper")}
"""By path: what recipes of earlier versions may have, which can no longer be trained, and a value
of today by which the rest of such a recipe is checked."""

FOR_PEOPLE = ("name", "summary", "default_steps", "ordered_steps")
"""Values of a recipe that do not affect what is learned."""

FORMER_NAMES = {
    "reward.snippet_pairs": "reward.fragment_pairs",
    "reward.snippet_min_steps": "reward.fragment_min_steps",
    "reward.snippet_max_steps": "reward.fragment_max_steps",
    "policy.n_games": "policy.n_envs",
    "policy.rollout_steps": "policy.n_steps",
    "policy.minibatches": "policy.n_minibatches",
    "policy.epochs": "policy.n_epochs",
    "policy.learning_rate_decays": "policy.anneal_lr",
    "policy.discount": "policy.gamma",
    "policy.gae": "policy.gae_lambda",
    "policy.clip": "policy.clip_range",
    "policy.entropy": "policy.ent_coef",
    "policy.value": "policy.vf_coef",
    "policy.gradient_norm": "policy.max_grad_norm",
    "policy.start_policy_pull": "policy.kl_coef",
    "cloning.left_out_share": "cloning.validation_share",
}
"""Today's path of each value that earlier versions called otherwise."""


def evaluated_on_own_start(recipe: Recipe, start_number: int) -> Recipe:
    """Return the recipe under the published protocol, without held-out starts.

    The published work trains one policy per start and evaluates it on that very start (thesis,
    section 6.1), which measures how well that one game was learned.

    Raises:
        Invalid: There is no such start.
    """
    values = {"policy.own_starts": (start_number,), "policy.opening_share": 0.0}
    recipe = with_values(recipe, values)
    return replace(recipe, evaluation=EvaluationRecipe((start_number,), ()))


def with_values(recipe: Recipe, values: Mapping[str, Any]) -> Recipe:
    """Return a copy with some values replaced.

    Args:
        recipe: The original.
        values: New values by dotted path, such as ``policy.learning_rate``. Text is read as the
            value's type; sequences have commas between.

    Raises:
        Invalid: There is no such value, or it is out of its range; the message names the range.
    """
    known_values = _by_path(recipe)
    data = recipe.to_dict()
    for path, value in values.items():
        if path not in known_values:
            raise Invalid(f"A recipe has no value {path!r}.{_suggestion(path, known_values)}")
        part, _, name = path.rpartition(".")
        (data[part] if part else data)[name] = value
    try:
        return _validator().validate_python(data)
    except ValidationError as error:
        problems = [_problem(detail) for detail in error.errors()[:MAX_PROBLEMS]]
        if error.error_count() > MAX_PROBLEMS:
            problems.append(f"And {error.error_count() - MAX_PROBLEMS:,} more.")
        raise Invalid(" ".join(problems)) from error


def checked(recipe: Recipe) -> Recipe:
    """Return a recipe whose values may come from anywhere; it may learn by a former method.

    Raises:
        Invalid: A value is out of its range.
    """
    values = _by_path(recipe)
    former = {path for path, (name, _) in FORMER_METHODS.items() if values[path] == name}
    today = with_values(recipe, {path: FORMER_METHODS[path][1] for path in former})
    if "reward.method" in former:
        today = replace(today, reward=replace(today.reward, method=recipe.reward.method))
    return replace(today, method=recipe.method) if "method" in former else today


def former_method(recipe: Recipe) -> str | None:
    """Return the method of a recipe that can no longer be trained; None if it can be."""
    values = _by_path(recipe)
    return next((name for path, (name, _) in FORMER_METHODS.items() if values[path] == name), None)


def changed_values(recipe: Recipe, original: Recipe) -> dict[str, Any]:
    """Return the values, by dotted path, with which with_values turns the original into the recipe.

    Those FOR_PEOPLE are left aside.
    """
    original_values = _by_path(original)
    return {
        path: value
        for path, value in _by_path(recipe).items()
        if value != original_values[path] and path not in FOR_PEOPLE
    }


def recipe_from_dict(data: Mapping[str, Any]) -> Recipe:
    """Rebuild a stored recipe.

    Recipes of earlier versions stay readable: unknown values are ignored, missing ones take their
    defaults, and ranges are not checked.

    Raises:
        Invalid: This is no recipe.
    """
    try:
        return _rebuilt(Recipe, data)
    except (TypeError, AttributeError) as error:
        raise Invalid(f"This is not a recipe of this version of Tril: {error}.") from error


def _rebuilt(kind: type[T], data: Mapping[str, Any]) -> T:
    if not isinstance(data, Mapping):
        raise TypeError(f"expected values by name, got {_shortened(data)}")
    values = {}
    for field in fields(kind):  # type: ignore[arg-type]
        if field.name in data:
            value = data[field.name]
            if is_dataclass(field.default):
                value = _rebuilt(type(field.default), value)
            values[field.name] = tuple(value) if isinstance(value, list) else value
    return kind(**values)


def _by_path(recipe: Recipe) -> dict[str, Any]:
    """Return all values by dotted path."""
    values: dict[str, Any] = {}
    for name, value in recipe.to_dict().items():
        inner_values = (
            {f"{name}.{key}": item for key, item in value.items()} if type(value) is dict else {}
        )
        values |= inner_values or {name: value}
    return values


def _suggestion(path: str, known_values: Mapping[str, Any]) -> str:
    if path in FORMER_NAMES:
        return f" It is called {FORMER_NAMES[path]!r} now."
    close = get_close_matches(path, known_values, n=1)
    return f" Did you mean {close[0]!r}?" if close else ""


@cache
def _validator() -> TypeAdapter[Recipe]:
    return TypeAdapter(Recipe)


def _problem(error: ErrorDetails) -> str:
    """Name the refused value, what it must be and what it was."""
    path, context = [str(key) for key in error["loc"][:2]], error.get("ctx", {})
    if error["type"] == "value_error":
        return ": ".join([*path[:1], f"{context['error']}."])
    hint: Any = Recipe
    for name in path:
        hint = get_type_hints(hint, include_extras=True)[name]
    described = [field.description for field in get_args(hint) if isinstance(field, FieldInfo)]
    expected = str(context.get("expected") or next(iter(described), None) or "text")
    if error["type"] == "less_than_equal" and f"{context['le']:,.0f}" not in expected:
        expected = f"at most {context['le']:,.0f}"
    return f"{'.'.join(path)} must be {expected}, got {_shortened(error['input'])}."


def _shortened(value: object) -> str:
    text = repr(value)
    return text if len(text) <= 60 else f"{text[:59]}…"
