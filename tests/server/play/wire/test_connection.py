"""Flow control and keys of one page, on a socket of the test's own."""

from __future__ import annotations

import asyncio
import time

import numpy as np
import pytest

from server.play.wire.connection import Connection
from server.play.wire.protocol import AckMessage, BadMessage, InputMessage, Paused
from server.play.wire.scene import Scene
from testsupport.protocol import parse_frame
from testsupport.space_invaders import Keys
from tril.games.space_invaders.memory import SCREEN_SHAPE

SCREEN = np.zeros(SCREEN_SHAPE, np.uint8)


def scene(frame: int, shots: int = 0) -> Scene:
    return Scene(frame, SCREEN, b"\0\0", shots)


class Wire:
    """A socket that keeps what was sent and can break."""

    def __init__(self) -> None:
        self.sent: list[bytes | str] = []
        self.closed: tuple[int, str | None] | None = None
        self.is_broken = False

    async def send_bytes(self, data: bytes) -> None:
        self._send(data)

    async def send_text(self, data: str) -> None:
        self._send(data)

    async def close(self, code: int = 1000, reason: str | None = None) -> None:
        self.closed = (code, reason)

    def _send(self, data: bytes | str) -> None:
        if self.is_broken:
            raise ConnectionResetError
        self.sent.append(data)


def test_at_most_six_frames_are_on_their_way() -> None:
    async def play() -> None:
        wire = Wire()
        connection = Connection(wire)
        shown = [await connection.show(scene(frame)) for frame in range(10)]
        assert shown == [True] * 6 + [False] * 4
        connection.receive(AckMessage(2))
        assert await connection.show(scene(10))
        assert await connection.show(scene(11))
        assert not await connection.show(scene(12))
        frames = [parse_frame(data).frame for data in wire.sent if isinstance(data, bytes)]
        assert frames == [0, 1, 2, 3, 4, 5, 10, 11]

    asyncio.run(play())


def test_frames_shown_at_the_same_time_keep_to_six_as_well() -> None:
    async def play() -> None:
        wire = Wire()
        connection = Connection(wire)
        shown = await asyncio.gather(*(connection.show(scene(frame)) for frame in range(10)))
        assert sum(shown) == 6
        sequences = [parse_frame(data).sequence for data in wire.sent if isinstance(data, bytes)]
        assert sequences == [1, 2, 3, 4, 5, 6]

    asyncio.run(play())


def test_a_page_stalls_only_while_frames_wait_for_it(monkeypatch: pytest.MonkeyPatch) -> None:
    now = 100.0
    monkeypatch.setattr(time, "monotonic", lambda: now)

    async def play() -> None:
        nonlocal now
        connection = Connection(Wire())
        now += 50
        for frame in range(6):
            await connection.show(scene(frame))
        assert connection.stalled_for_s == 0
        now += 3
        assert connection.stalled_for_s == 3
        connection.receive(AckMessage(1))
        assert connection.stalled_for_s == 0

    asyncio.run(play())


def test_acknowledging_what_was_not_sent_is_refused() -> None:
    connection = Connection(Wire())
    with pytest.raises(BadMessage):
        connection.receive(AckMessage(1))


def test_a_tap_between_two_frames_counts_for_one_frame() -> None:
    connection = Connection(Wire())
    connection.receive(InputMessage(Keys.FIRE, 1))
    connection.receive(InputMessage(Keys(0), 2))
    assert connection.take_buttons() == Keys.FIRE
    assert connection.take_buttons() == Keys(0)
    connection.receive(InputMessage(Keys.LEFT, 3))
    assert [connection.take_buttons() for _ in range(3)] == [Keys.LEFT] * 3


def test_a_frame_names_the_newest_input_that_it_was_executed_with() -> None:
    async def play() -> None:
        wire = Wire()
        connection = Connection(wire)
        connection.receive(InputMessage(Keys.LEFT, 1))
        await connection.show(scene(0))
        connection.take_buttons()
        connection.receive(InputMessage(Keys.RIGHT, 2))
        await connection.show(scene(1))
        connection.take_buttons()
        await connection.show(scene(2))
        named = [parse_frame(data).input_sequence for data in wire.sent if isinstance(data, bytes)]
        assert named == [0, 1, 2]

    asyncio.run(play())


def test_a_shot_is_told_with_the_first_frame_sent_after_it() -> None:
    async def play() -> None:
        wire = Wire()
        connection = Connection(wire)
        for frame, shots in enumerate((3, 3, 4, 4, 2, 3)):
            await connection.show(scene(frame, shots))
        connection.receive(AckMessage(1))
        # Two missiles while the page is behind are told once; a game that is run back tells none.
        connection.receive(AckMessage(6))
        await connection.show(scene(9, 5))
        told = [parse_frame(data).has_counted for data in wire.sent if isinstance(data, bytes)]
        assert told == [False, False, True, False, False, True, True]

    asyncio.run(play())


def test_a_latency_belongs_to_the_frame_that_was_drawn() -> None:
    async def play() -> None:
        connection = Connection(Wire())
        for frame in (40, 41, 43):
            await connection.show(scene(frame))
        connection.receive(AckMessage(1))
        connection.receive(AckMessage(3, 31.5))
        assert connection.take_latencies() == [(43, 31.5)]
        assert connection.take_latencies() == []

    asyncio.run(play())


def test_taps_while_the_game_is_not_running_can_be_discarded() -> None:
    connection = Connection(Wire())
    connection.receive(InputMessage(Keys.FIRE, 1))
    connection.receive(InputMessage(Keys.LEFT, 2))
    connection.discard_taps()
    assert connection.take_buttons() == Keys.LEFT


def test_a_page_that_has_gone_is_sent_nothing_more() -> None:
    async def play() -> None:
        wire = Wire()
        wire.is_broken = True
        connection = Connection(wire)
        await connection.send(Paused(why=""))
        assert not connection.is_open
        assert not await connection.show(scene(0))
        await connection.close(4001)
        assert wire.closed is None

    asyncio.run(play())


def test_a_close_reason_fits_into_its_frame() -> None:
    async def play() -> None:
        wire = Wire()
        await Connection(wire).close(4400, "ü" * 500)
        assert wire.closed is not None
        assert len((wire.closed[1] or "").encode()) <= 123

    asyncio.run(play())
