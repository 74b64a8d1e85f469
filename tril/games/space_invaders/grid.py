"""The absolute 6x6 grid of aliens and the ends of a game, from the RAM.

The RAM has one byte per row of aliens in which bit 0 is the leftmost column *that still has
aliens*: when that column empties, all rows shift right and the aliens' x jumps by a column. The
absolute grid therefore needs a count of these shifts since the start of the game.
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from tril.games.space_invaders import memory as game

Ram = bytes | npt.NDArray[np.uint8]
"""The RAM: 128 values from 0 to 255."""

_ROWS = slice(game.RAM_ALIEN_ROWS, game.RAM_ALIEN_ROWS + game.ROWS)
_FULL_ROWS = ((1 << game.COLUMNS) - 1,) * game.ROWS

# The aliens move by at most 4 pixels in a frame; a shift adds 16 for each emptied column.
_SHIFT_JUMP = game.COLUMN_WIDTH // 2


@dataclass(frozen=True)
class AlienGridState:
    """A saved AlienGrid.

    Attributes:
        rows: one mask per row, bottom row first; bit 0 is the leftmost column of the game.
        shifts: number of columns by which the RAM's rows have been shifted.
        alien_x: the aliens' x in the RAM at the last update.
    """

    rows: tuple[int, ...] = _FULL_ROWS
    shifts: int = 0
    alien_x: int = -1


@dataclass(frozen=True)
class Formation:
    """The position of the full 6x6 grid on the screen, in pixels.

    Attributes:
        left: of the first column; may be negative once that column is gone.
        top: of the top row.
    """

    left: int
    top: int


class AlienGrid:
    """The remaining aliens of a game, by their place in the full grid."""

    def __init__(self, ram: bytes) -> None:
        """Begin at a start, with all 36 aliens.

        Raises:
            ValueError: aliens are missing.
        """
        self._raw = ram[_ROWS]
        self._state = AlienGridState(alien_x=ram[game.RAM_ALIEN_X])
        if self._raw != bytes(_FULL_ROWS):
            raise ValueError(
                "Expected all 36 aliens at the start of a game. Later, restore the state of a grid"
                " that was followed from the start: the RAM alone does not tell the columns."
            )

    def update(self, ram: bytes) -> list[tuple[int, int]]:
        """Update the grid; call it after every frame of a game.

        Returns:
            The (row, column) of each alien hit in this frame.
        """
        raw = ram[_ROWS]
        alien_x = ram[game.RAM_ALIEN_X]
        state = self._state
        if raw == self._raw and alien_x == state.alien_x:
            return []
        shifts = state.shifts
        if alien_x - state.alien_x > _SHIFT_JUMP:
            shifts += round((alien_x - state.alien_x) / game.COLUMN_WIDTH)
        rows = tuple(row << shifts for row in raw)
        hits = [
            (row, column)
            for row, (before, after) in enumerate(zip(state.rows, rows, strict=True))
            if before != after
            for column in range(game.COLUMNS)
            if before & ~after & (1 << column)
        ]
        self._raw = raw
        self._state = AlienGridState(rows, shifts, alien_x)
        return hits

    @property
    def alive(self) -> npt.NDArray[np.bool_]:
        """The remaining aliens, bool (6, 6): row from the bottom, column from the left."""
        cells = [[row >> column & 1 for column in range(game.COLUMNS)] for row in self._state.rows]
        return np.array(cells, np.bool_)

    @property
    def shifts(self) -> int:
        """Number of emptied columns at the left: the column of the RAM's bit 0."""
        return self._state.shifts

    def formation(self, ram: Ram) -> Formation:
        """Return the position of the grid on the screen of the last update."""
        return Formation(
            left=int(ram[game.RAM_ALIEN_X]) + game.ALIEN_LEFT - game.COLUMN_WIDTH * self.shifts,
            top=game.TOP_ROW + game.ALIEN_Y_PX * int(ram[game.RAM_ALIEN_Y]),
        )

    def save(self) -> AlienGridState:
        """Return the state of the grid."""
        return self._state

    def restore(self, state: AlienGridState) -> None:
        """Restore a saved state."""
        self._state = state
        self._raw = bytes(row >> state.shifts for row in state.rows)


def in_play(ram: Ram) -> bool:
    """Return whether the game goes on: neither hit nor landed nor cleared nor in the intro."""
    return not (
        ram[game.RAM_PHASE]
        or ram[game.RAM_LANDING] & game.RAM_LANDED_BIT
        or not ram[game.RAM_ALIENS_LEFT]
    )


def player_hit(ram: Ram) -> bool:
    """Return whether the player has been hit: true from the frame of the hit on."""
    return int(ram[game.RAM_PHASE]) == game.PHASE_HIT


def landed(ram: Ram) -> bool:
    """Return whether the aliens have reached the ground."""
    return bool(ram[game.RAM_LANDING] & game.RAM_LANDED_BIT)


def cleared(ram: Ram) -> bool:
    """Return whether no alien is left."""
    return int(ram[game.RAM_ALIENS_LEFT]) == 0


def missile_in_air(ram: Ram) -> bool:
    """Return whether the player's missile is in the air."""
    return int(ram[game.RAM_MISSILE_Y]) != game.NO_MISSILE
