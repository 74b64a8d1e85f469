"""What a game survives: a killed server, a full disk."""

from __future__ import annotations

import sqlite3
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from sqlalchemy import event

from server.play.wire.protocol import Ended, Hello, Paused
from testsupport.live import LiveServer, join, live_server
from testsupport.processes import server_process
from testsupport.workplace import Workplace
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
    with server_process(data) as server:
        game = server.new_game()
        with join(server.settings, game) as player:
            player.begin()
            player.until_frame(150)
            server.process.kill()
            server.process.wait(10)
            assert player.close_code() is None
            seen = player.frames[-1].frame
    with live_server(data) as second, second.play(game) as player:
        hello = player.until(Hello)
        assert hello.resumed
        assert seen - hello.frame <= MOST_FRAMES_LOST
        player.say("ready")
        player.until_frame(hello.frame + 10)
        assert player.stop().verification == "verified"
