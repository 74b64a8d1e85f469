"""The grid of aliens read from the screen's pixels alone: no RAM."""

import numpy as np
import numpy.typing as npt

ALIEN_COLOUR = 20
COLUMN_PITCH, ROW_PITCH = 16, 18
ALIEN_WIDTH, ALIEN_HEIGHT = 8, 10
FIRST_LEFT, FIRST_TOP = 23, 31
SKY = slice(25, 195)


class ScreenReader:
    """Follows the grid's place on the screen from frame to frame.

    Between two frames the aliens move by a few pixels, much less than the gaps between them, so
    the place of the full grid is known even where its left columns are empty.
    """

    def __init__(self) -> None:
        self.left = FIRST_LEFT
        self.top = FIRST_TOP

    def read(self, screen: npt.NDArray[np.uint8]) -> npt.NDArray[np.bool_]:
        """Return which aliens are on the screen, bool (6, 6), row from the bottom."""
        ys, xs = np.nonzero(screen[SKY] == ALIEN_COLOUR)
        ys = ys + SKY.start
        if not self._inside(xs, ys).all():
            self._follow(xs, ys)
        inside = self._inside(xs, ys)
        seen = np.zeros((6, 6), np.bool_)
        rows_from_top = (ys[inside] - self.top) // ROW_PITCH
        seen[5 - rows_from_top, (xs[inside] - self.left) // COLUMN_PITCH] = True
        return seen

    def _follow(self, xs: npt.NDArray[np.int64], ys: npt.NDArray[np.int64]) -> None:
        """Move the grid by the least that brings the most pixels into its cells."""
        moves = sorted(
            ((dx, dy) for dx in range(-6, 7) for dy in (0, *range(-1, 13))),
            key=lambda move: abs(move[0]) + abs(move[1]),
        )
        dx, dy = max(moves, key=lambda move: self._inside(xs - move[0], ys - move[1]).sum())
        self.left += dx
        self.top += dy

    def _inside(
        self, xs: npt.NDArray[np.int64], ys: npt.NDArray[np.int64]
    ) -> npt.NDArray[np.bool_]:
        """Tell which pixels lie in a cell of the grid at its present place."""
        x, y = xs - self.left, ys - self.top
        in_cell = (x % COLUMN_PITCH < ALIEN_WIDTH) & (y % ROW_PITCH < ALIEN_HEIGHT)
        in_grid = (x >= 0) & (x < 6 * COLUMN_PITCH) & (y >= 0) & (y < 6 * ROW_PITCH)
        return np.asarray(in_cell & in_grid, np.bool_)
