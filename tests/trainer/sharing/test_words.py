"""What is measured of games, in words."""

from __future__ import annotations

import pytest

from trainer.sharing.words import measure_title
from tril.games import game_named
from tril.games.base import Rectangle
from tril.games.measures import InRegion


@pytest.mark.parametrize(
    ("edges", "part"),
    [
        ((0, 0, 40, 210), "left 25% of the screen"),
        ((120, 0, 160, 210), "right 25% of the screen"),
        ((0, 0, 160, 105), "upper 50% of the screen"),
        ((0, 105, 160, 210), "lower 50% of the screen"),
        ((0, 34, 160, 114), "area 0, 34 to 160, 114"),
        ((0, 0, 160, 210), "area 0, 0 to 160, 210"),
    ],
)
def test_a_side_of_the_screen_is_named_by_its_share(
    edges: tuple[int, int, int, int], part: str
) -> None:
    measure = InRegion(thing="player", area=Rectangle(*edges), at_least=0.9)
    title = measure_title(measure, game_named("pong"))
    assert title == f"Green paddle in the {part}: at least 90% of the time"
