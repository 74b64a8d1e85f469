"""The kinds of example, as data: which demonstrations there are, how they are played and ranked."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from tril.behaviours import Behaviour
from tril.demonstrator.manner import HUMAN, PERFECT, Manner
from tril.demonstrator.plans import N_DEMONSTRATIONS, DemonstrationPlan, example_plans
from tril.errors import Invalid


class Part(StrEnum):
    """What a demonstration is among the twelve: BEST hits all targets, GRADUAL some of them."""

    BEST = "best"
    GRADUAL = "gradual"
    NONE = "none"
    WRONG = "wrong"


@dataclass(frozen=True)
class ExampleKind:
    """A kind of example.

    Attributes:
        name: Its name on the command line and in recordings' conditions.
        summary: What it is, in words.
        n_ranked: How many demonstrations are ranked.
        parts: Of which parts of the twelve they are.
        manner: How they and the perfect ones are played.
        n_mistakes: Ranking mistakes: pairs of games of neighbouring tiers that are swapped.
    """

    name: str
    summary: str
    n_ranked: int = N_DEMONSTRATIONS
    parts: tuple[Part, ...] = tuple(Part)
    manner: Manner = PERFECT
    n_mistakes: int = 0

    def plans(self, behaviour: Behaviour) -> list[DemonstrationPlan]:
        """What is to be shown of a behaviour, best first.

        Of fewer demonstrations than there are plans, every so-and-so-many-th plan is shown; of
        more, the plans are gone through again, the best first: other games of the same.

        Raises:
            Invalid: The demonstrator can't show this behaviour.
        """
        every = example_plans(behaviour)
        none = next(index for index, plan in enumerate(every) if plan.most == 0)
        chosen = [plan for index, plan in enumerate(every) if _part(index, none) in self.parts]
        if self.n_ranked < len(chosen):
            at = np.linspace(0, len(chosen) - 1, self.n_ranked).round().astype(int)
            return [chosen[index] for index in at]
        again = [chosen[index % len(chosen)] for index in range(self.n_ranked)]
        return sorted(again, key=lambda plan: plan.number)


def _part(index: int, none: int) -> Part:
    if index == 0:
        return Part.BEST
    if index == none:
        return Part.NONE
    return Part.GRADUAL if index < none else Part.WRONG


SCRIPTED = ExampleKind("scripted", "the twelve, played flawlessly and ranked without mistakes")

KINDS: Sequence[ExampleKind] = (
    SCRIPTED,
    ExampleKind(
        "human",
        "the twelve as a person would play them, with mistakes in their ranking",
        manner=HUMAN,
        n_mistakes=3,
    ),
    ExampleKind("six", "every other of the twelve", n_ranked=6),
    ExampleKind("twenty-four", "each of the twelve in two games", n_ranked=24),
    ExampleKind(
        "no-wrong",
        "twelve without aliens that should not be hit",
        parts=(Part.BEST, Part.GRADUAL, Part.NONE),
    ),
    ExampleKind(
        "no-gradual",
        "twelve that hit all targets, none, or wrong aliens, with no steps between",
        parts=(Part.BEST, Part.NONE, Part.WRONG),
    ),
)


def kind_named(name: str) -> ExampleKind:
    """Return a kind of example by its name.

    Raises:
        Invalid: There is none of this name; says which there are.
    """
    for kind in KINDS:
        if kind.name == name:
            return kind
    names = ", ".join(kind.name for kind in KINDS)
    raise Invalid(f"There are no demonstrations {name!r}; there are {names}.")
