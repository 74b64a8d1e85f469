"""The learning recipes, as data. A run stores the whole recipe it was made with."""

from tril.recipes.ablations import ABLATIONS, Ablation
from tril.recipes.built_in import DAGGER, FAST, GAIL, PAPER, RECIPES, recipe_named
from tril.recipes.changed import (
    FOR_PEOPLE,
    changed_values,
    judged_where_trained,
    with_values,
)
from tril.recipes.stored import recipe_from_dict
from tril.recipes.values import (
    MOST_DAGGER_STEPS,
    CloningRecipe,
    DaggerRecipe,
    EvaluationRecipe,
    GailRecipe,
    Method,
    PolicyRecipe,
    Recipe,
    RewardRecipe,
)

__all__ = [
    "ABLATIONS",
    "DAGGER",
    "FAST",
    "FOR_PEOPLE",
    "GAIL",
    "MOST_DAGGER_STEPS",
    "PAPER",
    "RECIPES",
    "Ablation",
    "CloningRecipe",
    "DaggerRecipe",
    "EvaluationRecipe",
    "GailRecipe",
    "Method",
    "PolicyRecipe",
    "Recipe",
    "RewardRecipe",
    "changed_values",
    "judged_where_trained",
    "recipe_from_dict",
    "recipe_named",
    "with_values",
]
