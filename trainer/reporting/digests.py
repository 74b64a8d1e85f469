"""Digests that tell recipes with different values apart."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import MISSING, fields, is_dataclass
from functools import cache
from pathlib import Path
from typing import Any

from trainer.policy.networks import PRETRAINED
from trainer.reward.pretraining import WEIGHTS
from tril.analysis import wanted_aliens
from tril.errors import Invalid
from tril.recipes import FOR_PEOPLE, Recipe, RewardRecipe, with_values


def recipe_digest(recipe: Recipe | RewardRecipe) -> str:
    """Return eight hexadecimal digits that change when a value of the recipe does.

    Values that equal their field's default are left out, so that a new field does not change the
    digest of a recipe that keeps its default. So are the name, the summary and the steps that it
    proposes.
    Pretrained weights that the recipe begins with count as values.
    """
    values = {k: v for k, v in _non_default_values(recipe).items() if k not in FOR_PEOPLE}
    if weights := [_file_digest(path) for path in _pretrained_weights(recipe)]:
        values["weights"] = weights
    text = json.dumps(values, sort_keys=True)
    return hashlib.blake2b(text.encode(), digest_size=4).hexdigest()


def weights_digest() -> str:
    """Return eight hexadecimal digits that change when weights that ship with Tril do."""
    return "".join(_file_digest(path)[:4] for path in (WEIGHTS, PRETRAINED))


def inference_digest() -> str:
    """Return eight hexadecimal digits that change with how wanted aliens are inferred.

    The prior is no value of a recipe.
    """
    return _file_digest(Path(wanted_aliens.__file__))


def _pretrained_weights(recipe: Recipe | RewardRecipe) -> list[Path]:
    if isinstance(recipe, RewardRecipe):
        return [WEIGHTS] if recipe.pretrained else []
    uses_pretrained_policy = recipe.cloning.pretrained or recipe.policy.mixed_start
    policy = [PRETRAINED] if uses_pretrained_policy else []
    return _pretrained_weights(recipe.reward) + policy


@cache
def _file_digest(path: Path) -> str:
    return hashlib.blake2b(path.read_bytes(), digest_size=4).hexdigest()


def changed_recipe(base: Recipe, changes: Mapping[str, Any]) -> Recipe | None:
    """Return a recipe with changes by dotted path, as JSON stores them.

    Returns:
        None where this version has no such value, or the changes contradict the base.
    """
    values = {path: tuple(v) if isinstance(v, list) else v for path, v in changes.items()}
    try:
        return with_values(base, values)
    except Invalid:
        return None


def _non_default_values(part: Any) -> dict[str, Any]:
    values: dict[str, Any] = {}
    for field in fields(part):
        value = getattr(part, field.name)
        if is_dataclass(value):
            if inner := _non_default_values(value):
                values[field.name] = inner
        elif field.default is MISSING or value != field.default:
            values[field.name] = value
    if isinstance(part, RewardRecipe) and part.pretrained:
        # It used to be a value of its own, and counts in the digests of earlier results.
        values["pretrained"] = True
    return values
