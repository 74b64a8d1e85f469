"""Behaviours to teach."""

from __future__ import annotations

from dataclasses import dataclass

from tril.errors import Invalid
from tril.games.measures import Measure, check_number
from tril.games.settings import UNSET, GameSettings

Cell = tuple[int, int]
"""(row from the bottom, column from the left), both from 0, in a grid of items."""


@dataclass(frozen=True)
class Behaviour:
    """A behaviour that a person teaches.

    Attributes:
        slug: Short name used in URLs and on the command line, e.g. ``column-5``.
        name: Name shown to people, e.g. "Column 5".
        description: Description of a perfect game, in one or two sentences.
        game: Name of its game.
        target: Items to take, in order if ``ordered``; None if items do not describe it.
        ordered: Whether their order matters.
        settings: Settings of the game.
        measures: What of a game tells in numbers how well it shows the behaviour.
    """

    slug: str
    name: str
    description: str
    game: str
    target: tuple[Cell, ...] | None = None
    ordered: bool = False
    settings: GameSettings = UNSET
    measures: tuple[Measure, ...] = ()

    def __post_init__(self) -> None:
        if not self.name.strip():
            raise Invalid("A behaviour needs a name.")
        check_number(self.measures)
        if self.target is None:
            if self.ordered:
                raise Invalid("An order needs targets. Pick some or turn the order off.")
            return
        if not self.target:
            raise Invalid("Pick at least one target, or turn the target off.")
        if len(set(self.target)) != len(self.target):
            raise Invalid("A target is listed twice.")


@dataclass(frozen=True)
class Score:
    """The items taken in a game compared with a behaviour's target.

    Attributes:
        targets: Number of targets taken.
        strays: Number of other items taken.
        order_errors: Number of targets taken while an earlier one of the order was left; 0 for
            behaviours without an order.
    """

    targets: int
    strays: int
    order_errors: int

    @property
    def worth(self) -> int:
        """Targets minus strays, where a target out of order counts as a stray."""
        return self.targets - 2 * self.order_errors - self.strays


def score(behaviour: Behaviour, taken: tuple[Cell, ...]) -> Score | None:
    """Compare items, in order of time, with a behaviour's target; None without a target."""
    if behaviour.target is None:
        return None
    target = set(behaviour.target)
    on_target = [cell for cell in taken if cell in target]
    errors = 0
    if behaviour.ordered:
        position = {cell: index for index, cell in enumerate(behaviour.target)}
        pending = set(range(len(behaviour.target)))
        for cell in on_target:
            index = position[cell]
            errors += index > min(pending)
            pending.discard(index)
    return Score(len(on_target), len(taken) - len(on_target), errors)
