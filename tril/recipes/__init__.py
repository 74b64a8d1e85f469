"""The learning recipes, as data. A run stores the whole recipe that it was made with."""

from tril.recipes.built_in import ANY, FAST, GAIL, PAPER, RECIPES, recipe_named, recipes_for
from tril.recipes.changes import (
    FOR_PEOPLE,
    FORMER_NAMES,
    changed_values,
    checked,
    evaluated_on_own_start,
    former_method,
    recipe_from_dict,
    with_values,
)
from tril.recipes.values import (
    CloningRecipe,
    EvaluationRecipe,
    GailRecipe,
    Method,
    PolicyRecipe,
    Recipe,
    RewardRecipe,
)

__all__ = [
    "ANY",
    "FAST",
    "FORMER_NAMES",
    "FOR_PEOPLE",
    "GAIL",
    "PAPER",
    "RECIPES",
    "CloningRecipe",
    "EvaluationRecipe",
    "GailRecipe",
    "Method",
    "PolicyRecipe",
    "Recipe",
    "RewardRecipe",
    "changed_values",
    "checked",
    "evaluated_on_own_start",
    "former_method",
    "recipe_from_dict",
    "recipe_named",
    "recipes_for",
    "with_values",
]
