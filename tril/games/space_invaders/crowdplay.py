"""Behaviours that CrowdPlay asked people for, with its measures.

Gerstgrasser, Trivedi, Parkes 2022, CrowdPlay: Crowdsourcing Human Demonstrations for Offline
Learning. Their tasks lasted for many games, ours are one each, so that scores are not asked for.
"""

from __future__ import annotations

from collections.abc import Iterable

from tril.games.behaviours import Behaviour, Cell
from tril.games.measures import InRegion, ItemsInOrder, ItemsTaken, Measure
from tril.games.settings import Rectangle
from tril.games.space_invaders import memory as facts

SHARE = 0.9
"""What they asked for at least."""
_MIDDLE_PX = (facts.PLAYER_LEFT_WALL + facts.PLAYER_RIGHT_WALL) // 2 + 2
"""Where the cannon's centre is halfway between the walls."""
_HEIGHT, _WIDTH = facts.SCREEN_SHAPE


def _column(column: int) -> tuple[Cell, ...]:
    return tuple((row, column) for row in range(facts.ROWS))


def _row(row: int) -> tuple[Cell, ...]:
    return tuple((row, column) for column in range(facts.COLUMNS))


def _in_order(*sequences: Iterable[tuple[Cell, ...]]) -> tuple[Measure, ...]:
    order = ItemsInOrder(sequences=tuple(map(tuple, sequences)), at_least=SHARE)
    return (order, ItemsTaken(at_least=facts.ROWS))


def _side(left: int, right: int) -> tuple[Measure, ...]:
    area = Rectangle(left, 0, right, _HEIGHT)
    return (InRegion(thing="cannon", area=area, at_least=SHARE), ItemsTaken(at_least=facts.ROWS))


def _behaviour(slug: str, name: str, description: str, measures: tuple[Measure, ...]) -> Behaviour:
    return Behaviour(slug, name, description, "space_invaders", measures=measures)


CROWDPLAY = (
    _behaviour(
        "row-by-row",
        "Row by row",
        "Shoot the aliens of the lowest row, then those of the next, and none above them.",
        _in_order(map(_row, range(facts.ROWS))),
    ),
    _behaviour(
        "outside-in",
        "Outside in",
        "Shoot the outer columns first, then the next ones towards the middle.",
        _in_order(map(_column, (0, 1, 2)), map(_column, (5, 4, 3))),
    ),
    _behaviour(
        "inside-out",
        "Inside out",
        "Shoot the two columns in the middle first, then the next ones towards the edges.",
        _in_order(map(_column, (2, 1, 0)), map(_column, (3, 4, 5))),
    ),
    _behaviour(
        "keep-left",
        "Keep to the left",
        "Stay on the left half of the screen and shoot what is there.",
        _side(0, _MIDDLE_PX),
    ),
    _behaviour(
        "keep-right",
        "Keep to the right",
        "Stay on the right half of the screen and shoot what is there.",
        _side(_MIDDLE_PX, _WIDTH),
    ),
)
