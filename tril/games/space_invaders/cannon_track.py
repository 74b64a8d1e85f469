"""The cannon's position in every frame of a recording."""

from __future__ import annotations

import numpy as np

from tril.games.base import Start, Track
from tril.games.space_invaders import memory as game


def cannon_track(memory: bytes, start: Start) -> Track:
    """Read the cannon's track off a recording's memory.

    Args:
        memory: The RAM at the start and after every frame, 128 bytes each.
        start: The recording's; in difficulty 1 the cannon is twice as wide.
    """
    offset, width = game.CANNON_EDGES[start.to_json()["difficulty"]]
    rows = np.frombuffer(memory, np.uint8).reshape(-1, game.RAM_SIZE)
    at = rows[:, game.RAM_PLAYER_X].astype(int)
    # A screen shows the cannon where it was a frame before.
    shown_x = np.concatenate((at[:1], at[:-1]))
    return Track(tuple((shown_x + offset).tolist()), game.CANNON_TOP, width, game.CANNON_HEIGHT)
