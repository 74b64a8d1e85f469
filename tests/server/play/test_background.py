"""What the background tasks and the games do about unexpected errors."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Iterator
from typing import Any

import pytest

from server.play.background import PeriodicTask
from server.play.session.live_game import LiveGame
from server.play.wire.protocol import Close
from testsupport.live import LiveServer
from testsupport.waiting import wait_until
from tril.errors import Unavailable
from tril.store import games


def test_a_task_that_fails_is_run_again_after_ever_longer_pauses(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    failures: Iterator[Exception] = iter(
        [ValueError("a bug"), Unavailable("The disk is full."), *(ValueError() for _ in range(20))]
    )
    pauses: list[float] = []
    done = asyncio.Event()

    async def sleep(pause_s: float) -> None:
        pauses.append(pause_s)
        await no_sleep(0)

    async def work() -> None:
        failure = next(failures, None)
        if failure is None:
            done.set()
        else:
            raise failure

    async def run() -> None:
        task.start()
        await done.wait()
        await no_sleep(0)
        assert task.is_healthy
        await task.stop()
        assert not task.is_healthy

    no_sleep = asyncio.sleep
    monkeypatch.setattr(asyncio, "sleep", sleep)
    task = PeriodicTask("count", work, period_s=0.001)
    assert not task.is_healthy
    with caplog.at_level(logging.WARNING):
        asyncio.run(run())
    assert [round(pause_s) for pause_s in pauses[1:9]] == [1, 2, 4, 8, 16, 30, 30, 30]
    assert "ValueError: a bug" in caplog.text
    assert "The disk is full." in caplog.text


def test_saving_goes_on_after_an_unexpected_error_and_health_shows_it(
    live: LiveServer, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*_arguments: Any, **_more: Any) -> bool:
        raise RuntimeError("a bug")

    def n_saved() -> int:
        with live.database.reading() as session:
            return games.get(session, game["id"]).recording.n_frames

    def health() -> dict[str, Any]:
        found: dict[str, Any] = live.http.get("/api/health").json()
        return found

    game = live.new_game(start={"idle_frames": 4})
    with live.play(game) as player:
        with monkeypatch.context() as broken:
            broken.setattr(games, "save", fail)
            player.begin()
            player.until_frame(30)
            wait_until(lambda: health() == {"status": "degraded", "failing": ["save"]})
            assert n_saved() == 0
        seen = player.frames[-1].frame
        player.say("pause")
        wait_until(lambda: n_saved() >= seen)
        wait_until(lambda: health() == {"status": "ok"})
        assert player.stop().verification == "verified"


@pytest.mark.parametrize("command", ["ready", "step"])
def test_an_error_in_a_game_is_logged_and_the_game_goes_on_from_what_is_saved(
    live: LiveServer,
    monkeypatch: pytest.MonkeyPatch,
    caplog: pytest.LogCaptureFixture,
    command: str,
) -> None:
    def fail(*_arguments: Any) -> None:
        raise RuntimeError("a bug")

    game = live.new_game()
    with live.play(game) as player, monkeypatch.context() as broken:
        broken.setattr(LiveGame, "advance", fail)
        player.say(command)
        assert player.close_code() == Close.INTERNAL_ERROR
    assert "RuntimeError: a bug" in caplog.text
    with live.play(game) as player:
        player.begin()
        player.until_frame(5)
        assert player.stop().verification == "verified"
