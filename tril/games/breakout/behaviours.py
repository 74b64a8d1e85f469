"""Behaviours that come with Breakout."""

from __future__ import annotations

from tril.games.behaviours import Behaviour
from tril.games.breakout.wall import COLUMNS, ROWS
from tril.games.measures import AliveAtEnd, ItemsInOrder, ItemsTaken
from tril.games.settings import GameSettings

_LENGTH = GameSettings(max_steps=900)
"""A minute: the ball comes back every two to three seconds."""
TUNNEL_COLUMNS = 2

READY_MADE = (
    Behaviour(
        slug="left-tunnel",
        name="Left tunnel",
        description="Break a tunnel through the wall at its left edge and leave the rest alone.",
        game="breakout",
        settings=_LENGTH,
        measures=(
            ItemsTaken(
                cells=tuple((r, c) for r in range(ROWS) for c in range(TUNNEL_COLUMNS)),
                at_least=ROWS,
            ),
            ItemsTaken(
                cells=tuple((r, c) for r in range(ROWS) for c in range(TUNNEL_COLUMNS, COLUMNS)),
                at_most=6,
            ),
            AliveAtEnd(),
        ),
    ),
    Behaviour(
        slug="row-by-row",
        name="Row by row",
        description="Break no brick of a row before those of the rows below are gone.",
        game="breakout",
        settings=_LENGTH,
        measures=(
            ItemsInOrder(
                sequences=(tuple(tuple((r, c) for c in range(COLUMNS)) for r in range(ROWS)),),
                at_least=0.9,
            ),
            AliveAtEnd(),
        ),
    ),
)
