"""Games that clear the lowest rows, which varied play seldom does while aliens above are left."""

from __future__ import annotations

import numpy as np

from tril.demonstrators.space_invaders.plans import DemonstrationPlan, draw_hits
from tril.demonstrators.space_invaders.varied_play import play_towards
from tril.games.base import Cell, Console, draw_start
from tril.games.space_invaders import SPACE_INVADERS
from tril.games.space_invaders.memory import COLUMNS
from tril.recording import Verified

MAX_ROWS = 3
"""Most rows that a game that clears rows is played towards, from the lowest on."""

MIN_ROW_HITS = 4
MAX_ROW_HITS = 14
"""Fewest and most aliens that such a game is played towards; more can't be hit in 300 steps."""


def play_low_rows(rng: np.random.Generator, console: Console | None = None) -> Verified:
    """Play one game towards aliens of the lowest rows to its end and verify the recording.

    A third of the games clear row by row from left to right, a third from right to left, and the
    others hit what is nearest.

    Args:
        rng: Source of all draws.
        console: The console to play on; None loads one.

    Raises:
        RecordingRefused: The replay differs, because the emulator is not deterministic.
    """
    start = draw_start(SPACE_INVADERS.starts, rng)
    return play_towards(draw_low_rows(rng), start, rng, console or SPACE_INVADERS.make_console())


def draw_low_rows(rng: np.random.Generator) -> tuple[Cell, ...]:
    """Draw aliens (row, column) of the lowest one to three rows, in an order to hit them in."""
    n_rows = int(rng.integers(1, MAX_ROWS + 1))
    cells = [(row, column) for row in range(n_rows) for column in range(COLUMNS)]
    max_hits = min(MAX_ROW_HITS, len(cells))
    direction = int(rng.integers(3))
    if direction == 2:
        plan = DemonstrationPlan(1, "Low rows", frozenset(cells), MIN_ROW_HITS, max_hits)
        return draw_hits(plan, rng, first_column=int(rng.integers(COLUMNS)))
    cells.sort(key=lambda cell: (cell[0], cell[1] if direction == 0 else -cell[1]))
    return tuple(cells[: int(rng.integers(MIN_ROW_HITS, max_hits + 1))])
