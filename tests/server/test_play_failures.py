"""What a game survives: a killed server, a full disk."""

from __future__ import annotations

import os
import signal
import sqlite3
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import httpx2
import pytest
from sqlalchemy import event

from server.main import bind
from server.play.protocol import Ended, Hello, Paused
from tests.server.live import LiveServer, cookie, join, live_server
from tests.workplace import Workplace
from tril.settings import Settings
from tril.store import recordings
from tril.store.database import Database

MOST_FRAMES_LOST = 60


@contextmanager
def full_disk(database: Database) -> Iterator[None]:
    """Let every change of games and recordings fail as SQLite does when the disk is full."""

    def refuse(_cursor: Any, statement: str, _parameters: Any, _context: Any) -> None:
        if statement.startswith(("UPDATE", "INSERT")):
            raise sqlite3.OperationalError("database or disk is full")

    event.listen(database.engine, "do_execute", refuse)
    try:
        yield
    finally:
        event.remove(database.engine, "do_execute", refuse)


def test_a_full_disk_pauses_the_game_and_nothing_of_it_is_lost(live: LiveServer) -> None:
    with live.play(live.new_game()) as player:
        player.begin()
        player.until_frame(20)
        with full_disk(live.services.database):
            paused = player.until(Paused)
            assert "disk is full" in paused.why
            assert "Free some space" in paused.why
            standing = player.frames[-1].frame
            answer = live.http.patch("/api/player", json={"name": "Somebody"})
            assert answer.status_code == 503
            assert "Free some space" in answer.json()["detail"]
            player.say("stop")
            assert "disk is full" in player.until(Paused).why
        ended = player.until(Ended)
    assert ended.frame == standing
    assert ended.verification == "verified"
    with live.database.reading() as session:
        assert recordings.get(session, ended.recording_id).n_frames == standing


def test_a_killed_server_loses_at_most_a_second_of_a_game(workplace: Workplace) -> None:
    data = workplace.settings.data
    with _server_process(data) as (process, settings):
        with httpx2.Client(headers={"Cookie": cookie(settings)}) as http:
            base = f"http://127.0.0.1:{settings.port}"
            game = http.post(f"{base}/api/games", json={"behaviour_id": 1}).json()
        with join(settings, game) as player:
            player.begin()
            player.until_frame(150)
            process.send_signal(signal.SIGKILL)
            process.wait(10)
            assert player.close_code() is None
            seen = player.frames[-1].frame
    with live_server(data) as second, second.play(game) as player:
        hello = player.until(Hello)
        assert hello.resumed
        assert seen - hello.frame <= MOST_FRAMES_LOST
        player.say("ready")
        player.until_frame(hello.frame + 10)
        assert player.stop().verification == "verified"


@contextmanager
def _server_process(data: Path) -> Iterator[tuple[subprocess.Popen[str], Settings]]:
    """Run ``tril serve`` and wait until it answers."""
    with bind(Settings(data=data, port=0)) as free:
        port = free.getsockname()[1]
    settings = Settings(data=data, port=port)
    environment = {key: value for key, value in os.environ.items() if not key.startswith("TRIL_")}
    process = subprocess.Popen(
        [sys.executable, "-m", "cli.main", "serve"],
        env={**environment, "TRIL_DATA": str(data), "TRIL_PORT": str(port)},
        stderr=subprocess.PIPE,
        text=True,
    )
    try:
        _wait_for_start(process)
        yield process, settings
    finally:
        process.kill()
        process.wait(10)
        assert process.stderr is not None
        process.stderr.close()


def _wait_for_start(process: subprocess.Popen[str]) -> None:
    assert process.stderr is not None
    said = []
    for line in process.stderr:
        said.append(line)
        if "Application startup complete" in line:
            # What it says from now on has to be read, or it would stand still one day.
            threading.Thread(target=_drain, args=(process.stderr,), daemon=True).start()
            return
    pytest.fail("The server did not start: " + "".join(said))


def _drain(lines: Any) -> None:
    try:
        for _ in lines:
            pass
    except ValueError:
        return
