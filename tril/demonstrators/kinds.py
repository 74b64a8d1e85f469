"""The kinds of example: which demonstrations they contain and how these are played and ranked."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from tril.demonstrators.error_model import HUMAN, PERFECT, ErrorModel, person
from tril.demonstrators.space_invaders.plans import (
    N_DEMONSTRATIONS,
    DemonstrationPlan,
    example_plans,
)
from tril.errors import Invalid
from tril.games.behaviours import Behaviour


class PlanCategory(StrEnum):
    """The role of a plan among the twelve: BEST hits all targets, GRADUAL some of them."""

    BEST = "best"
    GRADUAL = "gradual"
    NONE = "none"
    WRONG = "wrong"


@dataclass(frozen=True)
class ExampleKind:
    """A kind of example.

    Attributes:
        name: Name on the command line and in recordings' conditions.
        summary: Description for help texts.
        n_ranked: Number of ranked demonstrations.
        categories: Categories of plans to draw from.
        error_model: Player errors, also in perfect demonstrations.
        n_mistakes: Ranking mistakes: pairs of games in adjacent tiers that are swapped.
        best_efforts: Whether the games for cloning are good ones as they come, see
            plans.best_effort_violation, instead of perfect ones only.
    """

    name: str
    summary: str
    n_ranked: int = N_DEMONSTRATIONS
    categories: tuple[PlanCategory, ...] = tuple(PlanCategory)
    error_model: ErrorModel = PERFECT
    n_mistakes: int = 0
    best_efforts: bool = False

    def plans(self, behaviour: Behaviour) -> list[DemonstrationPlan]:
        """Return the plans to demonstrate, best first.

        With fewer demonstrations than plans, plans are sampled at even intervals; with more, they
        repeat, starting from the best.

        Raises:
            Invalid: The demonstrator can't show this behaviour.
        """
        plans = example_plans(behaviour)
        empty_index = next(index for index, plan in enumerate(plans) if plan.max_hits == 0)
        chosen = [
            plan
            for index, plan in enumerate(plans)
            if _category(index, empty_index) in self.categories
        ]
        if self.n_ranked < len(chosen):
            indices = np.linspace(0, len(chosen) - 1, self.n_ranked).round().astype(int)
            return [chosen[index] for index in indices]
        repeated = [chosen[index % len(chosen)] for index in range(self.n_ranked)]
        return sorted(repeated, key=lambda plan: plan.number)


def _category(index: int, empty_index: int) -> PlanCategory:
    if index == 0:
        return PlanCategory.BEST
    if index == empty_index:
        return PlanCategory.NONE
    return PlanCategory.GRADUAL if index < empty_index else PlanCategory.WRONG


SCRIPTED = ExampleKind("scripted", "the twelve, played flawlessly and ranked without mistakes")

KINDS: Sequence[ExampleKind] = (
    SCRIPTED,
    ExampleKind(
        "human",
        "the twelve as a person would play them, with mistakes in their ranking",
        error_model=HUMAN,
        n_mistakes=3,
    ),
    *(
        ExampleKind(
            f"person-{reaction_ms}",
            f"the twelve of a person who reacts after {reaction_ms} ms, with mistakes in their"
            " ranking; best efforts instead of perfect games",
            error_model=person(reaction_ms),
            n_mistakes=3,
            best_efforts=True,
        )
        for reaction_ms in (150, 250, 350)
    ),
    ExampleKind("six", "every other of the twelve", n_ranked=6),
    ExampleKind("twenty-four", "each of the twelve in two games", n_ranked=24),
    ExampleKind(
        "no-wrong",
        "twelve without aliens that should not be hit",
        categories=(PlanCategory.BEST, PlanCategory.GRADUAL, PlanCategory.NONE),
    ),
    ExampleKind(
        "no-gradual",
        "twelve that hit all targets, none, or wrong aliens, with no steps between",
        categories=(PlanCategory.BEST, PlanCategory.NONE, PlanCategory.WRONG),
    ),
)


def kind_named(name: str) -> ExampleKind:
    """Return the kind of example with this name.

    Raises:
        Invalid: There is no such kind; the message lists the existing ones.
    """
    for kind in KINDS:
        if kind.name == name:
            return kind
    names = ", ".join(kind.name for kind in KINDS)
    raise Invalid(f"Unknown demonstrations {name!r}; choose one of {names}.")
