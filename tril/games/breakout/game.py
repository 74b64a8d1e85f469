"""Breakout as a game: that of the emulator, with bricks that are counted."""

from __future__ import annotations

from dataclasses import replace

from tril.errors import Invalid
from tril.games.atari.family import ATARI
from tril.games.base import Game, ItemGrid
from tril.games.breakout.behaviours import READY_MADE
from tril.games.breakout.readout import ENDS, BreakoutReadout
from tril.games.breakout.wall import COLUMNS, ROWS
from tril.games.things import Absence, Axis, Thing

MEMORY_NAMES = {
    57: "lives",
    72: "paddle, x",
    77: "score, tens and ones",
    99: "ball, x",
    101: "ball, y",
}
THINGS = {
    "paddle": Thing("paddle", x=Axis(-39.5, byte=72), y=Axis(190.5)),
    "ball": Thing(
        "ball",
        x=Axis(-48.5, byte=99),
        y=Axis(11, byte=101),
        absent=(Absence(101, 0, 0), Absence(101, 179, 255)),
    ),
}
"""The ball counts as absent below the paddle."""

_COLOURS = ("#4248c8", "#48a048", "#a2a22a", "#b47a30", "#c66c3a", "#c84848")
"""Colours of the rows, from the bottom."""


def _breakout() -> Game:
    plain = ATARI.game("breakout")
    if plain is None:
        raise Invalid("Breakout is not among the games of the emulator.")
    return replace(
        plain,
        ends=ENDS,
        new_readout=BreakoutReadout,
        items=ItemGrid(ROWS, COLUMNS, "brick", "bricks", "break", _COLOURS),
        things=THINGS,
        pieces="bricks",
        behaviours=READY_MADE,
        memory_names=MEMORY_NAMES,
    )


BREAKOUT = _breakout()
