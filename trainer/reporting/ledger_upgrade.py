"""Reads what version 0.1.0 wrote: ledger format 1, and a file for each extrapolation experiment.

Digests changed only because values of recipes were renamed, so results are found under new ones.
The tables are frozen: they hold what 0.1.0 wrote and what that was in format 2 when it came.
"""

from __future__ import annotations

from collections import defaultdict
from typing import Any

from trainer.reporting.digests import base_recipes, changed_recipe, recipe_digest

NAMES = {
    "reward.snippet_pairs": "reward.fragment_pairs",
    "reward.snippet_min_steps": "reward.fragment_min_steps",
    "reward.snippet_max_steps": "reward.fragment_max_steps",
    "reward.disturbed_share": "reward.perturbed_share",
    "reward.disturbed_copies": "reward.perturbed_copies",
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

BUILT_IN = {
    "fast": ("24f1e6a2", "95969cf2"),
    "paper": ("d905e156", "d905e156"),
    "dagger": ("fb06c7d6", "425cbf89"),
    "gail": ("15336bd2", "dd5191da"),
}
"""Digest of each built-in recipe of 0.1.0 in format 1 and in format 2."""

ABLATIONS: dict[str, tuple[str, dict[str, Any]]] = {
    "e8d3ba7d": ("6ce54f9b", {"reward.aligned": False, "reward.free_share": 0.0}),
    "0af433cf": ("7582e9d8", {"reward.perturbed_share": 0.0, "reward.perfect_share": 0.0}),
    "0c83e779": (
        "23816588",
        {"policy.reward": "sigmoid", "policy.reward_scale": 0.05, "policy.death_penalty": 0.0},
    ),
    "c14ba9bb": ("62deadbd", {"policy.death_penalty": 0.0}),
    "5f34b943": (
        "4326a333",
        {
            "policy.warm_start": False,
            "policy.kl_coef": 0.0,
            "policy.critic_warm_up_steps": 0,
            "policy.ent_coef": 0.01,
        },
    ),
    "149fd057": ("b7304a19", {"policy.demonstration_share": 0.0}),
}
"""New digest and changes of each ablation by its old digest; early entries lack the changes."""

REWARDS = {"28fbb542": "3ecb7e76"}
"""New digest by old of the reward part of ``fast``, which names extrapolation experiments."""


def upgraded(line: dict[str, Any]) -> dict[str, Any]:
    """Return a result of version 0.1.0 in format 2; later ones as they are.

    Raises:
        KeyError: It is no result.
    """
    if "version" in line:
        return line
    if "experiment" in line:
        digest = line["experiment"]["digest"]
        return line | {"experiment": line["experiment"] | {"digest": REWARDS.get(digest, digest)}}
    cell = line["cell"]
    changes = {NAMES.get(path, path): value for path, value in line.get("changes", {}).items()}
    digest, changes = ABLATIONS.get(cell["digest"], (_digest(cell, changes), changes))
    games = defaultdict(list)
    for game in line["games"]:
        of = game["figures"]
        games[f"{game['policy']} {game['choice']}"].append(
            (
                game["start"],
                game["held_out"],
                game["hits"],
                of["steps"],
                of["is_hit"],
                of["predicted_return"],
            )
        )
    shown = line["demonstrations"]
    return line | {
        "cell": cell | {"digest": digest},
        "changes": changes,
        "demonstrations": [(one["rank"], one["hits"], one["predicted_return"]) for one in shown],
        "games": games,
    }


def _digest(cell: dict[str, Any], changes: dict[str, Any]) -> str:
    """Return the new digest of a recipe; the old one where this version can't rebuild it."""
    name, old = cell["recipe"], cell["digest"]
    before, after = BUILT_IN.get(name, ("", ""))
    if old == before:
        return after
    for base in base_recipes(name).values():
        changed = changed_recipe(base, changes)
        if changes and changed is not None and recipe_digest(base) == after:
            return recipe_digest(changed)
    return str(old)
