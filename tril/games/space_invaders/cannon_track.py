"""The cannon's position in every frame of a recording."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tril.games.space_invaders import memory as game


@dataclass(frozen=True)
class CannonTrack:
    """The cannon's rectangle through a recording, in pixels of the screen.

    Attributes:
        lefts: Its left edge at the start and after every frame.
        top: Its top edge.
        width: Its width.
        height: Its height.
    """

    lefts: tuple[int, ...]
    top: int
    width: int
    height: int


def cannon_track(memory: bytes, difficulty: int) -> CannonTrack:
    """Read the cannon's track off a recording's memory.

    Args:
        memory: The RAM at the start and after every frame, 128 bytes each.
        difficulty: The recording's; in difficulty 1 the cannon is twice as wide.
    """
    offset, width = game.CANNON_EDGES[difficulty]
    rows = np.frombuffer(memory, np.uint8).reshape(-1, game.RAM_SIZE)
    at = rows[:, game.RAM_PLAYER_X].astype(int)
    # A screen shows the cannon where it was a frame before.
    shown = np.concatenate((at[:1], at[:-1]))
    return CannonTrack(tuple((shown + offset).tolist()), game.CANNON_TOP, width, game.CANNON_HEIGHT)
