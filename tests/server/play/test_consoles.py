"""Consoles are loaded while nobody plays, and share what they know."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from server.play.consoles import ConsolePool
from tril.games.atari.starts import AtariStart
from tril.games.space_invaders import SPACE_INVADERS


@pytest.fixture
def pool() -> Iterator[ConsolePool]:
    made = ConsolePool()
    yield made
    made.stop()


def test_consoles_are_loaded_ahead_only_while_nobody_plays() -> None:
    ahead = ConsolePool(n_ahead=2)
    looked = threading.Event()
    with ahead.loading_suspended():
        ahead.start()
        assert not looked.wait(0.3)
        assert ahead.n_loaded == 0
    first, second = ahead.take(SPACE_INVADERS), ahead.take(SPACE_INVADERS)
    assert first is not second
    assert ahead.n_loaded == 2
    ahead.stop()


def test_whoever_needs_a_console_while_others_play_gets_the_next_that_is_given_back(
    pool: ConsolePool,
) -> None:
    console = pool.take(SPACE_INVADERS)
    with pool.loading_suspended(), ThreadPoolExecutor(1) as thread:
        waiting = thread.submit(pool.take, SPACE_INVADERS)
        pool.give_back(console)
        assert waiting.result(20) is console
    assert pool.n_loaded == 1


def test_whoever_needs_a_console_gets_one_as_soon_as_nobody_plays(pool: ConsolePool) -> None:
    with ThreadPoolExecutor(1) as thread:
        with pool.loading_suspended():
            waiting = thread.submit(pool.take, SPACE_INVADERS)
            assert not waiting.done()
        waiting.result(20)
    assert pool.n_loaded == 1


def test_a_start_that_another_console_reached_is_the_same_start(pool: ConsolePool) -> None:
    first, second, alone = (
        pool.take(SPACE_INVADERS),
        pool.take(SPACE_INVADERS),
        SPACE_INVADERS.make_console(),
    )
    for start in (AtariStart(40), AtariStart(9), AtariStart(77)):
        first.start(start)
        second.start(start)
        alone.start(start)
        for _ in range(30):
            second.act(3)
            alone.act(3)
        assert second.state_hash() == alone.state_hash()
        np.testing.assert_array_equal(second.screen(), alone.screen())


def test_several_threads_may_reach_starts_at_the_same_time(pool: ConsolePool) -> None:
    def reach(idle_frames: int) -> str:
        with pool.lent(SPACE_INVADERS) as console:
            console.start(AtariStart(idle_frames))
            return console.state_hash()

    starts = list(range(0, 128, 4))
    with ThreadPoolExecutor(4) as threads:
        reached = list(threads.map(reach, starts))
    alone = SPACE_INVADERS.make_console()
    for idle_frames, found in zip(starts, reached, strict=True):
        alone.start(AtariStart(idle_frames))
        assert alone.state_hash() == found
