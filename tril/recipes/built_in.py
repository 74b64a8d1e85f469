"""The built-in recipes."""

from __future__ import annotations

from dataclasses import replace

from tril.errors import Invalid
from tril.recipes.changes import with_values
from tril.recipes.values import CloningRecipe, PolicyRecipe, Recipe, RewardRecipe

PAPER = Recipe(
    name="paper",
    summary="As published: 30,000 single fragment pairs, sigmoid reward, PPO from scratch.",
    default_steps=10_000_000,
)

FAST_0_2 = Recipe(
    name="fast",
    summary="Minutes on a laptop: aligned fragments, reward for progress, a head start by cloning.",
    default_steps=1_000_000,
    reward=RewardRecipe(
        method="fast",
        learning_rate=1e-3,
        updates=300,
        fragment_pairs=0,
        pairs_per_update=256,
        fragment_min_steps=24,
        fragment_max_steps=100,
        observation_stride=12,
        aligned=True,
        free_share=0.33,
        perfect_share=0.05,
        perturbed_share=0.6,
        perturbed_copies=12,
        weight_decay=1e-3,
        folds=6,
        fold_updates=60,
        fold_stride=24,
    ),
    policy=PolicyRecipe(
        network="small",
        reward="difference",
        death_penalty=0.3,
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
        critic_warm_up_steps=12_000,
        snapshot_steps=tuple(range(50_000, 10_000_001, 50_000)),
        snapshot_episodes=24,
    ),
    cloning=CloningRecipe(network="small"),
)

FAST = replace(
    with_values(
        FAST_0_2,
        {
            "policy.death_forfeit": 0.5,
            "policy.opening_share": 1.0,
            "policy.sticky_action_probability": 0.25,
            "policy.freeze_convolutions": True,
            "cloning.pretrained": True,
            "cloning.freeze_convolutions": True,
            "evaluation.openings": True,
        },
    ),
    reward=RewardRecipe(
        method="posterior",
        updates=500,
        fragment_min_steps=24,
        fragment_max_steps=100,
        aligned=True,
        folds=6,
        fold_updates=500,
        pretrained=True,
    ),
    default_steps=600_000,
    ordered_steps=1_800_000,
    summary=(
        "Recommended; minutes on a laptop: infers which aliens the order asks for and begins with"
        " a clone."
    ),
)

DAGGER = Recipe(
    name="dagger",
    summary=(
        "Baseline with a privileged teacher: the scripted player, which reads the game's memory,"
        " corrects the policy's own games."
    ),
    default_steps=15_000,
    method="dagger",
    reward=FAST_0_2.reward,
    policy=PolicyRecipe(
        network="small",
        reward="level",
        death_penalty=5.0,
        reward_scale=0.05,
        learning_rate=5e-4,
        snapshot_episodes=24,
    ),
    cloning=FAST_0_2.cloning,
)

GAIL = Recipe(
    name="gail",
    summary=(
        "Baseline without a ranking: PPO from the clone on, against a network that tells its games"
        " from the perfect ones."
    ),
    default_steps=FAST.default_steps,
    method="gail",
    reward=FAST_0_2.reward,
    policy=PolicyRecipe(
        network="small",
        reward="softplus",
        reward_scale=0.05,
        n_envs=16,
        n_minibatches=8,
        ent_coef=0.0,
        warm_start=True,
        critic_warm_up_steps=12_000,
        snapshot_steps=(),
        snapshot_episodes=24,
    ),
    cloning=FAST_0_2.cloning,
)

FORMER: dict[str, Recipe] = {"0.2": FAST_0_2}
"""Former recipes by the last version that had them; most published figures are of these."""

RECIPES: dict[str, Recipe] = {recipe.name: recipe for recipe in (FAST, PAPER, DAGGER, GAIL)}


def recipe_named(name: str) -> Recipe:
    """Return a built-in recipe.

    Raises:
        Invalid: There is none of this name; the message lists the names.
    """
    try:
        return RECIPES[name]
    except KeyError:
        raise Invalid(f"There is no recipe {name!r}; choose one of {', '.join(RECIPES)}.") from None
