"""The behaviours of the published work."""

from __future__ import annotations

from tril.games.behaviours import Behaviour
from tril.games.space_invaders.memory import COLUMNS, ROWS


def _column(number: int) -> Behaviour:
    place = {1: "the leftmost column", 6: "the rightmost column"}
    column = place.get(number, f"column {number}, counted from the left,")
    return Behaviour(
        slug=f"column-{number}",
        name=f"Column {number}",
        description=f"Shoot all six aliens of {column} and no other, and stay alive.",
        game="space_invaders",
        target=tuple((row, number - 1) for row in range(ROWS)),
    )


ROW_1 = Behaviour(
    slug="row-1",
    name="Row 1",
    description="Sweep the bottom row from left to right, hit no other alien, and stay alive.",
    game="space_invaders",
    target=tuple((0, column) for column in range(COLUMNS)),
    ordered=True,
)

BUILT_IN: tuple[Behaviour, ...] = (*(_column(number) for number in range(1, 7)), ROW_1)
"""The behaviours of the published work: columns 1 to 6 and row 1."""
