"""How late frames begin, and the log of it."""

from __future__ import annotations

import asyncio
import logging
import math
from collections.abc import Coroutine

import pytest
from hypothesis import given
from hypothesis import strategies as st

from server.play.lateness import BIN_MS, N_BINS, Lateness, LatenessLog
from server.play.session.clock import FrameClock

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


class Time:
    """Stands for the event loop and for asyncio.sleep, on a clock of its own."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.now_s = 100.0
        monkeypatch.setattr(asyncio, "get_running_loop", lambda: self)
        monkeypatch.setattr(asyncio, "sleep", self.sleep)

    def time(self) -> float:
        return self.now_s

    async def sleep(self, delay_s: float) -> None:
        self.now_s += delay_s

    def run(self, waiting: Coroutine[None, None, None]) -> None:
        with pytest.raises(StopIteration):
            waiting.send(None)


FRAME_S = 1 / 60


@pytest.mark.parametrize(("percent", "frame_s"), [(100, FRAME_S), (50, 2 * FRAME_S), (25, 1 / 15)])
def test_frames_are_a_sixtieth_of_a_second_apart_or_more_in_slow_motion(
    monkeypatch: pytest.MonkeyPatch, percent: int, frame_s: float
) -> None:
    time, lateness = Time(monkeypatch), Lateness()
    clock = FrameClock("a game", 60, lateness)
    for n in range(1, 31):
        time.run(clock.wait(percent))
        assert time.now_s == pytest.approx(100 + n * frame_s)
    assert lateness.percentile_ms(1.0) == BIN_MS


@pytest.mark.parametrize(("held_up_s", "is_made_up"), [(0.06, True), (2.0, False)])
def test_a_clock_that_was_held_up_notes_it_and_makes_up_for_little_only(
    monkeypatch: pytest.MonkeyPatch, held_up_s: float, is_made_up: bool
) -> None:
    time, lateness = Time(monkeypatch), Lateness()
    clock = FrameClock("a game", 60, lateness)
    time.now_s += held_up_s
    for _ in range(12):
        time.run(clock.wait(100))
    lost_s = 0 if is_made_up else held_up_s - FRAME_S
    assert time.now_s == pytest.approx(100 + 12 * FRAME_S + lost_s)
    latest = lateness.percentile_ms(1.0)
    assert latest is not None
    assert (latest > 1000 * (held_up_s - FRAME_S)) == is_made_up


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
        lateness.note(0.0201)
        log.report(n_games=0)
    (message,) = caplog.messages
    assert "more than 20 ms late, with 3 games" in message
    assert "TRIL_SERVER_PROCESSES" in message
