"""Behaviours as people might add them, beside the built-in ones."""

from __future__ import annotations

from tril.games.behaviours import Behaviour
from tril.games.space_invaders.behaviours import BUILT_IN

OWN = (
    Behaviour(
        "block-2x3",
        "Left block",
        "The three lowest aliens of columns 1 and 2.",
        "space_invaders",
        tuple((row, column) for column in (0, 1) for row in range(3)),
    ),
    Behaviour(
        "block-3x2",
        "Middle block",
        "The two lowest aliens of columns 3 to 5.",
        "space_invaders",
        tuple((row, column) for row in range(2) for column in (2, 3, 4)),
    ),
    Behaviour(
        "row-1-any-order",
        "Row 1 in any order",
        "All aliens of the bottom row, in any order.",
        "space_invaders",
        tuple((0, column) for column in range(6)),
    ),
    Behaviour(
        "lower-column-3",
        "Lower column 3",
        "The four lowest aliens of column 3.",
        "space_invaders",
        tuple((row, 2) for row in range(4)),
    ),
)

BEHAVIOURS = {one.slug: one for one in (*BUILT_IN, *OWN)}
"""All of them by slug."""
