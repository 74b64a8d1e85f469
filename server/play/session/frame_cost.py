"""Where the frames of a game are executed: in the event loop, or in a thread if they are slow."""

from __future__ import annotations

import asyncio
import math
import time
from collections import deque
from collections.abc import Callable
from statistics import median
from typing import TypeVar

SLOW_FRAME_S = 0.008
"""Half a frame at 60 Hz: other games' frames would be late by it. A frame of Atari takes 0.3 ms."""

N_RECENT = 5

_Result = TypeVar("_Result")


class FrameCost:
    """Executes the frames of a game, and remembers how long the last ones took.

    Another thread costs about 0.1 ms a frame. A game begins in one, since nothing is known of it.
    """

    def __init__(self) -> None:
        self._recent = deque([math.inf] * N_RECENT, N_RECENT)

    @property
    def is_slow(self) -> bool:
        """Whether the next frame is executed in a thread."""
        return median(self._recent) > SLOW_FRAME_S

    async def execute(self, frame: Callable[[], _Result]) -> _Result:
        """Execute a frame and return its result; other games go on meanwhile if it is slow."""

        def timed() -> tuple[_Result, float]:
            started_s = time.perf_counter()
            result = frame()
            return result, time.perf_counter() - started_s

        result, seconds = await asyncio.to_thread(timed) if self.is_slow else timed()
        self._recent.append(seconds)
        return result
