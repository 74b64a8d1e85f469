"""Ablations of the fast recipe of 0.2: what it adds to the published one, factor by factor."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from tril.recipes.built_in import FAST_0_2
from tril.recipes.changes import with_values
from tril.recipes.values import Recipe


@dataclass(frozen=True)
class Ablation:
    """The fast recipe of 0.2 without one of its factors.

    Attributes:
        name: The factor, in words that follow "without".
        instead: What takes its place.
        values: The changed values by dotted path, see with_values.
    """

    name: str
    instead: str
    values: Mapping[str, Any]

    @property
    def recipe(self) -> Recipe:
        """The recipe without the factor."""
        return with_values(FAST_0_2, self.values)


ABLATIONS: Sequence[Ablation] = (
    Ablation(
        "fragments aligned in time",
        "the better fragment of a ranked pair starts no earlier (T-REX, section 4)",
        {"reward.aligned": False, "reward.free_share": 0.0},
    ),
    Ablation(
        "perturbed demonstrations of perfect games",
        "all fragment pairs are of the ranking",
        {"reward.perturbed_share": 0.0, "reward.perfect_share": 0.0},
    ),
    Ablation(
        "reward for progress",
        "sigmoid(R) at each step (thesis, section 5.1), scaled for the critic, no death penalty",
        {"policy.reward": "sigmoid", "policy.reward_scale": 0.05, "policy.death_penalty": 0.0},
    ),
    Ablation(
        "death penalty",
        "the end of the game is all that a hit costs",
        {"policy.death_penalty": 0.0},
    ),
    Ablation(
        "head start by cloning",
        "PPO starts from random weights, with an ent_coef of 0.01 and neither KL term nor warm-up",
        {
            "policy.warm_start": False,
            "policy.kl_coef": 0.0,
            "policy.critic_warm_up_steps": 0,
            "policy.ent_coef": 0.01,
        },
    ),
    Ablation(
        "episodes from states of the best demonstrations",
        "all episodes start at a training start",
        {"policy.demonstration_share": 0.0},
    ),
)
