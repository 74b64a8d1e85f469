"""The clock of a game: 60 frames a second, or slower, against absolute deadlines."""

from __future__ import annotations

import asyncio
import logging

from server.play.conditions import FULL_SPEED_PERCENT
from server.play.lateness import Lateness
from tril.game import space_invaders as game

_LOG = logging.getLogger(__name__)

FRAME_S = 1.0 / game.FRAME_RATE_HZ
MAX_LAG_S = 0.25
"""A clock that is later than this has stood still, and goes on from now instead of rushing."""


class FrameClock:
    """Says when the next frame is due; the first one is due at once.

    Args:
        game_id: The game whose clock it is.
        lateness: Where to note how late it comes.
    """

    def __init__(self, game_id: str, lateness: Lateness) -> None:
        self._game_id = game_id
        self._lateness = lateness
        self._loop = asyncio.get_running_loop()
        self._deadline = self._loop.time()

    async def wait(self, speed_percent: int) -> None:
        """Wait until a frame at this speed has passed since the last deadline."""
        self._deadline += FRAME_S * FULL_SPEED_PERCENT / speed_percent
        now = self._loop.time()
        if now - self._deadline > MAX_LAG_S:
            _LOG.warning("Game %s stood still for %.2f s.", self._game_id, now - self._deadline)
            self._deadline = now
        await asyncio.sleep(max(0.0, self._deadline - now))
        self._lateness.note(self._loop.time() - self._deadline)


async def happens_within(event: asyncio.Event, seconds: float) -> bool:
    """Wait for an event; returns whether it happened in time."""
    try:
        await asyncio.wait_for(event.wait(), seconds)
    except TimeoutError:
        return False
    return True
