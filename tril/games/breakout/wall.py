"""The wall of bricks in the console's memory."""

from __future__ import annotations

from tril.games.base import Cell

ROWS, COLUMNS = 6, 18

# A row of the wall is 36 halves of bricks, 4 px each, from x = 8 on. They are the bits of six
# playfield registers, of which each has its six rows one after the other, the lowest first. Of
# every second register the halves are in the order of falling bits.
_REGISTERS: tuple[tuple[int, tuple[int, ...]], ...] = (
    (30, (6, 7)),
    (24, (7, 6, 5, 4, 3, 2, 1, 0)),
    (18, (0, 1, 2, 3, 4, 5, 6, 7)),
    (12, (4, 5, 6, 7)),
    (6, (7, 6, 5, 4, 3, 2, 1, 0)),
    (0, (0, 1, 2, 3, 4, 5)),
)
_HALVES = [(register, bit) for register, bits in _REGISTERS for bit in bits]

LEFT_PX, TOP_PX = 8, 57
BRICK_PX = (6, 8)
"""Height and width of a brick."""


def _place(row: int, column: int) -> tuple[int, int]:
    """Return the address of a brick and the bits of its halves, which one byte holds."""
    (register, bit), (_, other_bit) = _HALVES[2 * column : 2 * column + 2]
    return register + row, 1 << bit | 1 << other_bit


BRICKS: dict[Cell, tuple[int, int]] = {
    (row, column): _place(row, column) for row in range(ROWS) for column in range(COLUMNS)
}
"""Address and bits of each brick, by row from the bottom and column from the left."""


def standing(ram: bytes) -> frozenset[Cell]:
    """Return the bricks that stand."""
    return frozenset(brick for brick, (address, bits) in BRICKS.items() if ram[address] & bits)
