"""Where frames are executed."""

from __future__ import annotations

import asyncio
import threading
import time
from functools import partial

from server.play.session.frame_cost import N_RECENT, SLOW_FRAME_S, FrameCost


async def threads_of(cost: FrameCost, seconds: list[float]) -> list[bool]:
    """Execute frames that take so long; return for each whether it left the loop's thread."""

    def frame(duration_s: float) -> int:
        time.sleep(duration_s)
        return threading.get_ident()

    own = threading.get_ident()
    return [await cost.execute(partial(frame, duration_s)) != own for duration_s in seconds]


def test_quick_frames_come_to_the_event_loop_and_slow_ones_leave_it() -> None:
    slow = [2 * SLOW_FRAME_S] * N_RECENT
    majority = N_RECENT // 2 + 1
    moved = asyncio.run(threads_of(FrameCost(), [*[0.0] * 20, *slow, 0.0]))
    assert moved[:majority] == [True] * majority
    assert not any(moved[majority : 20 + majority])
    assert moved[-1]


def test_a_single_slow_frame_changes_nothing() -> None:
    moved = asyncio.run(threads_of(FrameCost(), [*[0.0] * 9, 0.05, *[0.0] * 9]))
    assert not any(moved[N_RECENT:])
