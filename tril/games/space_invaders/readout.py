"""What is read of an episode of Space Invaders: aliens shot, missiles fired, how it ends."""

from __future__ import annotations

import struct

from tril.games.base import Console, JsonObject, Readout, Taken
from tril.games.space_invaders.ends import Ending, EndReason
from tril.games.space_invaders.grid import (
    AlienGrid,
    AlienGridState,
    cleared,
    in_play,
    landed,
    missile_in_air,
    player_hit,
)

_MARKS = struct.Struct("<BB")
MARKS_BYTES = _MARKS.size
LEFT_BIAS_PX = 96
"""Offset of the first column's position, which can be up to six columns of 16 px off the screen."""


class SpaceInvadersReadout:
    """Follows one episode.

    Attributes:
        taken: The aliens shot so far.
        counters: The missiles that left the cannon.
        grid: The remaining aliens.
        missile_in_air: Whether the player's missile is in the air.
    """

    def __init__(self, console: Console, end_rule: str) -> None:
        """Begin at a start."""
        ram = console.ram_bytes()
        self.taken: list[Taken] = []
        self.counters = {"shots": 0}
        self.grid = AlienGrid(ram)
        self.missile_in_air = missile_in_air(ram)
        self._ends_at_hit = end_rule == Ending.HIT
        self._lives = console.lives

    def update(self, console: Console, frame: int) -> str | None:
        """Read a frame that was executed; return the name of the end that it brought, if any."""
        ram = console.ram_bytes()
        for row, column in self.grid.update(ram):
            self.taken.append(Taken(row, column, frame))
        in_air = missile_in_air(ram)
        if in_air is not self.missile_in_air:
            self.counters["shots"] += in_air
            self.missile_in_air = in_air
        return None if in_play(ram) else self._end(console, ram)

    def _end(self, console: Console, ram: bytes) -> str | None:
        if self._ends_at_hit and player_hit(ram):
            return EndReason.HIT.value
        if not self._ends_at_hit and console.lives < self._lives:
            # Landing takes all lives at once.
            return (EndReason.LANDED if landed(ram) else EndReason.LIVES).value
        if landed(ram):
            return EndReason.LANDED.value
        return EndReason.CLEARED.value if cleared(ram) else None

    def marks(self, console: Console) -> bytes:
        """Return the position of the grid of aliens on the screen, two bytes."""
        formation = self.grid.formation(console.ram_bytes())
        return _MARKS.pack((formation.left + LEFT_BIAS_PX) % 256, formation.top % 256)

    def save(self) -> JsonObject:
        """Return the state, besides items and counters."""
        aliens = self.grid.save()
        return {
            "lives": self._lives,
            "missile_in_air": self.missile_in_air,
            "alien_rows": aliens.rows,
            "shifts": aliens.shifts,
            "alien_x": aliens.alien_x,
        }

    def restore(self, state: JsonObject) -> None:
        """Restore a saved state."""
        self._lives = state["lives"]
        self.missile_in_air = state["missile_in_air"]
        rows = tuple(state["alien_rows"])
        self.grid.restore(AlienGridState(rows, state["shifts"], state["alien_x"]))


def alien_grid(readout: Readout) -> AlienGrid:
    """Return the remaining aliens of an episode of Space Invaders, by its readout.

    Raises:
        TypeError: The episode is of another game.
    """
    if not isinstance(readout, SpaceInvadersReadout):
        raise TypeError(f"Expected an episode of Space Invaders, got {type(readout).__name__}.")
    return readout.grid
