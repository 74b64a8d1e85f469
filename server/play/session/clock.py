"""The clock of a game: its frame rate, or slower, against absolute deadlines."""

from __future__ import annotations

import asyncio
import logging
import time
from collections.abc import Awaitable, Callable

from server.play.conditions import FULL_SPEED_PERCENT
from server.play.lateness import Lateness
from tril.errors import TrilError

_LOG = logging.getLogger(__name__)

MAX_LAG_S = 0.25
"""Lag beyond which the deadlines restart from now instead of catching up."""

MAX_GAP_S = 1.0
"""A game that stood still for longer is paused: its player does not expect it to go on."""

_CLOCK = getattr(time, "CLOCK_BOOTTIME", getattr(time, "CLOCK_MONOTONIC", None))
"""A clock that runs while the machine sleeps. asyncio's does not on Linux and macOS."""


class ProcessSuspended(TrilError):
    """Time jumped: the process, or the whole machine, was suspended or too busy to play."""


class JumpDetector:
    """Detects that time jumped, e.g. because the process or the machine was suspended."""

    def __init__(self) -> None:
        self._at_s = _elapsed_s()

    def restart(self) -> None:
        """Accept the time that has passed."""
        self._at_s = _elapsed_s()

    def check(self, planned_s: float) -> None:
        """Compare the time since the last call, or the restart, with what was planned.

        Raises:
            ProcessSuspended: It was more than MAX_GAP_S longer.
        """
        now = _elapsed_s()
        gap_s, self._at_s = now - self._at_s - planned_s, now
        if gap_s > MAX_GAP_S:
            raise ProcessSuspended(
                f"The server stood still for {gap_s:.0f} s, so the game is paused. Was the machine "
                "asleep, or very busy?"
            )


def _elapsed_s() -> float:
    return time.monotonic() if _CLOCK is None else time.clock_gettime(_CLOCK)


class FrameClock:
    """Paces the frames of a game; the first one is due at once.

    Args:
        game_id: The game, for the log.
        frame_rate_hz: Frames a second at full speed.
        lateness: The histogram that each frame's lateness is added to.
    """

    def __init__(self, game_id: str, frame_rate_hz: int, lateness: Lateness) -> None:
        self._game_id = game_id
        self._frame_s = 1.0 / frame_rate_hz
        self._lateness = lateness
        self._loop = asyncio.get_running_loop()
        self._deadline = self._loop.time()
        self._jumps = JumpDetector()

    async def wait(
        self, speed_percent: int, ready: Callable[[], Awaitable[None]] | None = None
    ) -> None:
        """Wait until a frame at this speed has passed since the last deadline.

        Args:
            speed_percent: Speed in percent of the game's frame rate.
            ready: Waits for whatever else the next frame needs. If that is more than a frame late,
                the clock stands still meanwhile: the deadlines restart from then.

        Raises:
            ProcessSuspended: Time jumped.
        """
        self._deadline += self._frame_s * FULL_SPEED_PERCENT / speed_percent
        now = self._loop.time()
        if now - self._deadline > MAX_LAG_S:
            _LOG.warning("Game %s stood still for %.2f s.", self._game_id, now - self._deadline)
            self._deadline = now
        wait_s = max(0.0, self._deadline - now)
        await asyncio.sleep(wait_s)
        self._jumps.check(wait_s)
        if ready is not None:
            await ready()
            self._jumps.restart()
        now = self._loop.time()
        self._lateness.note(now - self._deadline)
        if ready is not None and now - self._deadline > self._frame_s:
            self._deadline = now


async def is_set_within(event: asyncio.Event, timeout_s: float) -> bool:
    """Wait for an event; returns whether it was set in time."""
    try:
        await asyncio.wait_for(event.wait(), timeout_s)
    except TimeoutError:
        return False
    return True
