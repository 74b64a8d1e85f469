"""Games while time jumps: the server, or its machine, was suspended."""

from __future__ import annotations

import signal
import time
from collections.abc import Callable, Iterator

import pytest

from server.play.session import clock
from server.play.session.clock import MAX_GAP_S, JumpDetector, ProcessSuspended
from server.play.wire.protocol import Alive, Countdown, FrameMessage, Hello, Paused
from testsupport.live import GameClient, LiveServer, join
from testsupport.processes import TrilProcess, server_process
from testsupport.protocol import parse_server
from testsupport.workplace import make_workplace

SUSPENDED_S = 2.5
SLEPT_S = 60.0


@pytest.fixture(scope="module")
def process(tmp_path_factory: pytest.TempPathFactory) -> Iterator[TrilProcess]:
    """Return a server in a process of its own."""
    made = make_workplace(tmp_path_factory.mktemp("jumps") / "data")
    made.database.close()
    with server_process(made.settings.data) as server:
        yield server


@pytest.fixture
def sleep(monkeypatch: pytest.MonkeyPatch) -> Callable[[], None]:
    """Return what lets the machine sleep: only the clock that runs meanwhile notices."""

    def fall_asleep() -> None:
        elapsed_s = clock._elapsed_s
        monkeypatch.setattr(clock, "_elapsed_s", lambda: elapsed_s() + SLEPT_S)

    return fall_asleep


def suspend(server: TrilProcess) -> None:
    """Suspend a server's process for a while."""
    server.process.send_signal(signal.SIGSTOP)
    time.sleep(SUSPENDED_S)
    server.process.send_signal(signal.SIGCONT)


def expect_pause(player: GameClient) -> None:
    """Expect the game to be paused for the jump, and to go on when the player says so."""
    paused = player.until(Paused)
    assert "stood still" in paused.why
    player.say("go_on")
    player.until(Countdown, lambda message: message.seconds == 0)


def test_a_game_is_paused_after_its_server_was_suspended(process: TrilProcess) -> None:
    with join(process.settings, process.new_game()) as player:
        player.begin()
        player.until_frame(30)
        suspend(process)
        paused = player.until(Paused)
        assert "stood still for" in paused.why
        # The frames on their way, and the one during which time stopped.
        assert player.frames[-1].frame < 30 + SUSPENDED_S * 60 / 2
        standing = player.frames[-1].frame
        player.say("go_on")
        player.until(Countdown, lambda message: message.seconds == 0)
        player.until_frame(standing + 10)
        ended = player.stop()
    assert ended.verification == "verified"


def test_a_countdown_is_paused_after_the_server_was_suspended(process: TrilProcess) -> None:
    with join(process.settings, process.new_game()) as player:
        player.begin()
        player.until(Countdown)
        suspend(process)
        expect_pause(player)


def test_a_game_is_paused_after_the_machine_slept(
    live: LiveServer, sleep: Callable[[], None]
) -> None:
    with live.playing(20) as player:
        sleep()
        paused = player.until(Paused)
        assert f"{SLEPT_S:.0f} s" in paused.why
        standing = player.frames[-1].frame
        player.say("go_on")
        player.until_frame(standing + 10)


def test_a_rewind_ends_where_it_began_after_the_machine_slept(
    live: LiveServer, sleep: Callable[[], None]
) -> None:
    with live.playing(60) as player:
        player.say("rewind")
        player.until(FrameMessage, lambda message: message.frame < 40)
        newest = max(frame.frame for frame in player.frames)
        sleep()
        assert "stood still" in player.until(Paused).why
        assert player.stop().frame >= newest


def test_a_detector_notices_gaps_and_no_plans(monkeypatch: pytest.MonkeyPatch) -> None:
    now = 100.0
    monkeypatch.setattr(clock, "_elapsed_s", lambda: now)
    jumps = JumpDetector()
    now += 3.0
    jumps.check(3.0)
    now += MAX_GAP_S
    jumps.check(0.0)
    now += 9.0
    jumps.restart()
    jumps.check(0.0)
    now += MAX_GAP_S + 0.1
    with pytest.raises(ProcessSuspended, match="1 s"):
        jumps.check(0.0)
    jumps.check(0.0)


def test_a_page_hears_that_the_server_is_alive_while_nothing_happens(live: LiveServer) -> None:
    with live.play(live.new_game()) as player:
        player.until(Hello)
        player.until(FrameMessage)
        for _ in range(2):
            told = player.socket.recv(timeout=5)
            assert isinstance(told, str)
            assert parse_server(told) == Alive()
