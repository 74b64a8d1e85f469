"""Behaviours to teach, and the seven built-in ones."""

from __future__ import annotations

from dataclasses import dataclass

from tril.errors import Invalid
from tril.games.space_invaders.memory import COLUMNS, ROWS
from tril.games.space_invaders.memory import Cell as Cell


@dataclass(frozen=True)
class Behaviour:
    """A behaviour that a person teaches.

    Attributes:
        slug: Short name used in URLs and on the command line, e.g. ``column-5``.
        name: Name shown to people, e.g. "Column 5".
        description: What a perfect game looks like, in one or two sentences.
        target: Cells to hit, in order if ``ordered``; None if hits do not describe the behaviour.
        ordered: Whether the order of the hits matters.
    """

    slug: str
    name: str
    description: str
    target: tuple[Cell, ...] | None = None
    ordered: bool = False

    def __post_init__(self) -> None:
        if not self.name.strip():
            raise Invalid("A behaviour needs a name.")
        if self.target is None:
            if self.ordered:
                raise Invalid("An order needs target aliens. Pick some or turn the order off.")
            return
        if not self.target:
            raise Invalid("Pick at least one alien, or turn the target off.")
        if len(set(self.target)) != len(self.target):
            raise Invalid("A target alien is listed twice.")
        for row, column in self.target:
            if not (0 <= row < ROWS and 0 <= column < COLUMNS):
                raise Invalid(
                    f"Expected target aliens in rows 0..{ROWS - 1} and columns 0..{COLUMNS - 1}, "
                    f"got ({row}, {column})."
                )


@dataclass(frozen=True)
class Score:
    """The hits of a game compared with a behaviour's target.

    Attributes:
        targets: Number of target cells hit.
        strays: Number of hits outside the target.
        order_errors: Number of target hits while an earlier target of the order was still
            standing; 0 for behaviours without an order.
    """

    targets: int
    strays: int
    order_errors: int

    @property
    def worth(self) -> int:
        """Targets minus strays, where a target out of order counts as a stray."""
        return self.targets - 2 * self.order_errors - self.strays


def score(behaviour: Behaviour, hits: tuple[Cell, ...]) -> Score | None:
    """Compare hits, in order of time, with a behaviour's target; None without a target."""
    if behaviour.target is None:
        return None
    wanted = set(behaviour.target)
    on_target = [cell for cell in hits if cell in wanted]
    errors = 0
    if behaviour.ordered:
        position = {cell: index for index, cell in enumerate(behaviour.target)}
        pending = set(range(len(behaviour.target)))
        for cell in on_target:
            index = position[cell]
            errors += index > min(pending)
            pending.discard(index)
    return Score(len(on_target), len(hits) - len(on_target), errors)


def _column(number: int) -> Behaviour:
    place = {1: "the leftmost column", 6: "the rightmost column"}
    what = place.get(number, f"column {number}, counted from the left,")
    return Behaviour(
        slug=f"column-{number}",
        name=f"Column {number}",
        description=f"Shoot all six aliens of {what} and no other, and stay alive.",
        target=tuple((row, number - 1) for row in range(ROWS)),
    )


ROW_1 = Behaviour(
    slug="row-1",
    name="Row 1",
    description="Sweep the bottom row from left to right, hit no other alien, and stay alive.",
    target=tuple((0, column) for column in range(COLUMNS)),
    ordered=True,
)

BUILT_IN: tuple[Behaviour, ...] = (*(_column(number) for number in range(1, 7)), ROW_1)
"""The behaviours of the published work: columns 1 to 6 and row 1."""
