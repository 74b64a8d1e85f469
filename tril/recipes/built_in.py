"""The built-in recipes."""

from __future__ import annotations

from dataclasses import replace

from tril.errors import Invalid
from tril.recipes.values import (
    CloningRecipe,
    EvaluationRecipe,
    PolicyRecipe,
    Recipe,
    RewardRecipe,
)

PAPER = Recipe(
    name="paper",
    summary=(
        "As published; takes hours: a network learns the order from screens alone, whatever it is"
        " about; PPO from scratch."
    ),
    default_steps=10_000_000,
)

FAST = Recipe(
    name="fast",
    summary=(
        "Minutes on a laptop: infers which aliens the order asks for and begins with a clone."
    ),
    default_steps=600_000,
    ordered_steps=1_800_000,
    reward=RewardRecipe(
        method="posterior",
        updates=500,
        fragment_min_steps=24,
        fragment_max_steps=100,
        aligned=True,
        folds=6,
        fold_updates=500,
    ),
    policy=PolicyRecipe(
        network="small",
        reward="difference",
        death_penalty=0.3,
        death_forfeit=0.5,
        reward_scale=2.0,
        n_envs=16,
        n_minibatches=8,
        n_epochs=4,
        anneal_lr=True,
        ent_coef=0.0,
        best_share=0.25,
        demonstration_share=0.25,
        warm_start=True,
        kl_coef=0.03,
        freeze_convolutions=True,
        critic_warm_up_steps=12_000,
        snapshot_steps=tuple(range(50_000, 10_000_001, 50_000)),
        snapshot_episodes=24,
        opening_share=1.0,
        sticky_action_probability=0.25,
    ),
    cloning=CloningRecipe(network="small", pretrained=True, freeze_convolutions=True),
    evaluation=EvaluationRecipe(openings=True),
)

ANY = Recipe(
    name="any",
    summary=(
        "For any behaviour in any game; a quarter of an hour on a laptop: infers what the order is"
        " about, and says it in words."
    ),
    default_steps=300_000,
    reward=RewardRecipe(
        method="statement",
        updates=1_500,
        fragment_min_steps=24,
        fragment_max_steps=100,
        aligned=True,
        folds=6,
    ),
    policy=replace(
        FAST.policy,
        reward="level",
        death_penalty=0.0,
        death_forfeit=0.0,
        reward_scale=0.05,
        snapshot_episodes=12,
        mixed_start=True,
        kl_coef=0.0,
    ),
    cloning=FAST.cloning,
    evaluation=FAST.evaluation,
)

GAIL = replace(
    FAST,
    name="gail",
    summary=(
        "Baseline without a ranking: PPO from the clone on, against a network that tells its games"
        " from the perfect ones."
    ),
    method="gail",
    policy=replace(
        FAST.policy, reward="softplus", reward_scale=0.05, death_forfeit=0.0, snapshot_steps=()
    ),
)

RECIPES: dict[str, Recipe] = {recipe.name: recipe for recipe in (FAST, ANY, PAPER, GAIL)}


def _unprepared(cloning: CloningRecipe) -> CloningRecipe:
    return replace(cloning, pretrained=False, freeze_convolutions=False, scale_layers=True)


_FROM_SCREENS: dict[str, Recipe] = {
    ANY.name: replace(
        ANY,
        policy=replace(
            ANY.policy,
            mixed_start=False,
            freeze_convolutions=False,
            kl_coef=FAST.policy.kl_coef,
        ),
        cloning=_unprepared(ANY.cloning),
    ),
    PAPER.name: PAPER,
    GAIL.name: replace(
        GAIL,
        reward=PAPER.reward,
        policy=replace(GAIL.policy, freeze_convolutions=False),
        cloning=_unprepared(GAIL.cloning),
    ),
}


def recipes_for(pretrained: bool, has_target: bool = True) -> dict[str, Recipe]:
    """Return the recipes for a behaviour by name, the proposed one first.

    Args:
        pretrained: Whether networks that ship with Tril have learned to read its game's screens
            (`tril.games.base.Game.pretrained`); else only what learns from screens alone is left.
        has_target: Whether the behaviour says which items are wanted, which `FAST` looks for; one
            that does not may be about anything.
    """
    if not pretrained:
        return _FROM_SCREENS
    return RECIPES if has_target else {ANY.name: ANY} | RECIPES


def recipe_named(name: str, pretrained: bool = True) -> Recipe:
    """Return a built-in recipe.

    Args:
        name: Name of a built-in recipe.
        pretrained: As for `recipes_for`.

    Raises:
        Invalid: There is none of this name for such a game; the message lists the names.
    """
    recipes = recipes_for(pretrained)
    if name in recipes:
        return recipes[name]
    names = ", ".join(recipes)
    if name in RECIPES:
        raise Invalid(
            f"The recipe {name!r} needs networks that have learned to read the game's screens,"
            f" which this game does not have; choose one of {names}."
        )
    raise Invalid(f"There is no recipe {name!r}; choose one of {names}.")
