"""How late frames begin, and the log of it."""

from __future__ import annotations

import asyncio
import logging
import math
import time

import pytest
from hypothesis import given
from hypothesis import strategies as st

from server.play.lateness import BIN_MS, N_BINS, Lateness, LatenessLog
from server.play.session.clock import FRAME_S, FrameClock

LONGEST_MS = BIN_MS * (N_BINS - 1)


@given(
    late_ms=st.lists(st.floats(0, LONGEST_MS - 0.01), min_size=1),
    share=st.sampled_from([0.0, 0.5, 0.9, 0.99, 1.0]),
)
def test_a_percentile_is_the_nearest_rank_rounded_up_to_a_bin(
    late_ms: list[float], share: float
) -> None:
    lateness = Lateness()
    for ms in late_ms:
        lateness.note(ms / 1000)
    exact = sorted(late_ms)[max(0, math.ceil(share * len(late_ms)) - 1)]
    found = lateness.percentile_ms(share)
    assert found is not None
    assert exact - 1e-6 <= found <= exact + BIN_MS + 1e-6


def test_times_are_added_up_and_taken_apart() -> None:
    lateness = Lateness()
    assert lateness.percentile_ms(0.5) is None
    lateness.note(-0.001)
    earlier = lateness + Lateness()
    lateness.note(3.0)
    assert (earlier.n_frames, lateness.n_frames) == (1, 2)
    assert (lateness.percentile_ms(0.5), lateness.percentile_ms(1.0)) == (BIN_MS, BIN_MS * N_BINS)
    recent = lateness - earlier
    assert (recent.n_frames, recent.percentile_ms(0.5)) == (1, BIN_MS * N_BINS)
    assert Lateness(recent.counts).counts == recent.counts
    with pytest.raises(ValueError, match="256 bins"):
        Lateness([1, 2])


def test_a_clock_that_was_held_up_says_by_how_much_and_catches_up() -> None:
    held_up_s, n_frames = 0.06, 12

    async def play() -> tuple[Lateness, float]:
        lateness = Lateness()
        began = asyncio.get_running_loop().time()
        clock = FrameClock("a game", lateness)
        for frame in range(n_frames):
            if frame == 2:
                time.sleep(held_up_s)
            await clock.wait(100)
        return lateness, asyncio.get_running_loop().time() - began

    lateness, took_s = asyncio.run(play())
    assert lateness.n_frames == n_frames
    latest = lateness.percentile_ms(1.0)
    assert latest is not None
    assert latest >= 1000 * (held_up_s - FRAME_S)
    assert took_s >= n_frames * FRAME_S


def test_the_log_says_when_games_are_late_and_what_helps(caplog: pytest.LogCaptureFixture) -> None:
    lateness = Lateness()
    log = LatenessLog(lateness)
    with caplog.at_level(logging.WARNING):
        lateness.note(0.004)
        log.report(n_games=3)
        assert not caplog.messages
        for _ in range(100):
            lateness.note(0.0201)
        log.report(n_games=3)
        log.report(n_games=3)
    (message,) = caplog.messages
    assert "more than 20 ms late, with 3 games" in message
    assert "TRIL_SERVER_PROCESSES" in message
