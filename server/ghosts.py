"""Where the cannon of a recording stood in every frame, to be drawn over another game. Pure."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tril.game import space_invaders as game


@dataclass(frozen=True)
class CannonTrack:
    """A cannon's way through a recording, in pixels of the screen.

    Attributes:
        lefts: Its left edge on the start's screen and on that of every frame.
        top: Its top edge.
        width: Its width.
        height: Its height.
    """

    lefts: tuple[int, ...]
    top: int
    width: int
    height: int


def cannon_track(memory: bytes, difficulty: int) -> CannonTrack:
    """Follow the cannon of a recording.

    Args:
        memory: The RAM at the start and after every frame, see memory_file.
        difficulty: The recording's; the cannon is twice as wide in the second.
    """
    offset, width = game.CANNON_EDGES[difficulty]
    rows = np.frombuffer(memory, np.uint8).reshape(-1, game.RAM_SIZE)
    at = rows[:, game.RAM_PLAYER_X].astype(int)
    # A screen shows the cannon where it was a frame before.
    shown = np.concatenate((at[:1], at[:-1]))
    return CannonTrack(tuple((shown + offset).tolist()), game.CANNON_TOP, width, game.CANNON_HEIGHT)
