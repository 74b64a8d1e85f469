"""What a page may send: ample for honest play, cut off before a flood slows anybody down."""

from __future__ import annotations

import threading
import time
from contextlib import suppress

import pytest

from server.play.wire.byte_budget import BURST_BYTES, RATE_BYTES_PER_S, TokenBucket
from server.play.wire.protocol import FrameMessage, Hello, InputMessage
from testsupport.live import GameClient, join
from testsupport.processes import server_process
from testsupport.protocol import client_bytes
from testsupport.space_invaders import Keys
from testsupport.workplace import Workplace

MESSAGE_BYTES = 14
"""An INPUT or an ACK with its WebSocket header and mask."""
PING_TIMEOUT_S = 20
FLOOD_BYTES = 40 * 2**20
WINDOW_S = 2.0


def test_inputs_and_acknowledgements_at_60_hz_stay_within_the_budget() -> None:
    bucket = TokenBucket(RATE_BYTES_PER_S, BURST_BYTES, now_s=0.0)
    assert all(bucket.take(2 * MESSAGE_BYTES, n / 60) for n in range(60 * 600))
    # A connection that stalls delivers everything at once.
    assert bucket.take(60 * MESSAGE_BYTES * (PING_TIMEOUT_S - 1), now_s=620.0)


@pytest.mark.parametrize("chunk_bytes", [MESSAGE_BYTES, 1000])
def test_a_flood_exhausts_the_budget_until_it_refills(chunk_bytes: int) -> None:
    bucket = TokenBucket(RATE_BYTES_PER_S, BURST_BYTES, now_s=5.0)
    taken = sum(bucket.take(chunk_bytes, now_s=5.0) for _ in range(10_000)) * chunk_bytes
    assert BURST_BYTES - chunk_bytes < taken <= BURST_BYTES
    assert bucket.take(BURST_BYTES, now_s=5.01 + BURST_BYTES / RATE_BYTES_PER_S)
    assert not bucket.take(BURST_BYTES + 1, now_s=1000.0)


def frames_received(player: GameClient) -> int:
    """Play for a while with an input for every frame; returns how many frames came."""
    until, before = time.monotonic() + WINDOW_S, len(player.frames)
    with suppress(TimeoutError):
        while (left_s := until - time.monotonic()) > 0:
            if isinstance(player.next(left_s), FrameMessage):
                player.hold(Keys.LEFT if len(player.frames) % 2 else Keys.RIGHT)
    return len(player.frames) - before


def flood(player: GameClient) -> int:
    """Send inputs until the connection breaks; returns how many bytes were sent."""
    data = client_bytes(InputMessage(Keys.FIRE, 1))
    chunk = 5000 * (bytes([0x82, 0x80 | len(data), 0, 0, 0, 0]) + data)
    sent = 0
    with suppress(OSError):
        while sent < FLOOD_BYTES:
            player.socket.socket.sendall(chunk)
            sent += len(chunk)
    return sent


def test_a_flooding_socket_is_cut_off_and_slows_nobody_down(workplace: Workplace) -> None:
    sent: list[int] = []
    with server_process(workplace.settings.data) as server:
        game, others = server.new_game(start={"idle_frames": 4}), server.new_game()
        with join(server.settings, game) as player, join(server.settings, others) as flooding:
            flooding.until(Hello)
            player.begin()
            player.until_frame(5)
            before = frames_received(player)
            thread = threading.Thread(target=lambda: sent.append(flood(flooding)))
            thread.start()
            during = frames_received(player)
            assert during > before / 2
            player.until_frame(player.frames[-1].frame + 60)
            assert player.stop().verification == "verified"
            assert flooding.close_code() is None, "cut off without a closing handshake"
            thread.join()
        assert sent[0] < FLOOD_BYTES
        server.wait_for("sent more than")
        with join(server.settings, others) as back:
            assert back.begin().resumed is False
            back.until_frame(5)
        assert sum("sent more than" in line for line in server.output) == 1
