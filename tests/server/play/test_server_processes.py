"""Several real server processes behind one port."""

from __future__ import annotations

import json
import socket
import threading
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import psutil
import pytest

from server.main import bind, take_port
from server.play.wire.protocol import Hello
from testsupport.live import TIMEOUT_S, join
from testsupport.processes import SERVER_STARTED, TrilProcess, server_process
from testsupport.workplace import make_workplace
from tril.errors import Unavailable
from tril.settings import Settings
from tril.store import games
from tril.store.database import Database, create_database

MOST_FRAMES_LOST = 60
MOST_TRIES = 60
"""The kernel chooses a process for each connection: 2**-60 is never."""


@pytest.fixture(scope="module")
def two(tmp_path_factory: pytest.TempPathFactory) -> Iterator[TrilProcess]:
    made = make_workplace(tmp_path_factory.mktemp("two") / "data")
    made.database.close()
    with server_process(made.settings.data, 2) as server:
        yield server


@pytest.fixture
def database(two: TrilProcess) -> Iterator[Database]:
    opened = create_database(two.settings.application_url)
    yield opened
    opened.close()


def owner_of(database: Database, game: dict[str, Any]) -> int:
    """Return the process that has a game."""
    with database.reading() as session:
        return int(games.get(session, game["id"]).owner.rsplit("-", 1)[1])


def test_a_game_goes_on_in_the_other_process(two: TrilProcess, database: Database) -> None:
    game = two.new_game()
    with join(two.settings, game) as player:
        player.begin()
        player.until_frame(90)
        first = owner_of(database, game)
        seen = player.frames[-1].frame
    assert first in two.pids
    for _ in range(MOST_TRIES):
        with join(two.settings, game) as player:
            hello = player.until(Hello)
            assert hello.resumed
            assert seen - hello.frame <= MOST_FRAMES_LOST
            if owner_of(database, game) == first:
                continue
            assert owner_of(database, game) in two.pids
            player.say("ready")
            player.until_frame(hello.frame + 30)
            assert player.stop().verification == "verified"
            return
    pytest.fail("Every connection came to the same process.")


def test_two_tabs_in_two_processes_have_one_owner(two: TrilProcess, database: Database) -> None:
    game = two.new_game()
    with join(two.settings, game) as first, ExitStack() as tabs:
        first.begin()
        first.until_frame(30)
        before = owner_of(database, game)
        for _ in range(MOST_TRIES):
            second = tabs.enter_context(join(two.settings, game))
            frame = second.until(Hello).frame
            if owner_of(database, game) != before:
                break
        else:
            pytest.fail("Every connection came to the same process.")
        second.say("ready")
        second.until_frame(frame + 90)
        # Within a second the other process finds that a save of its own is refused, if it played
        # on at all.
        assert first.close_code() == 4001
        assert second.stop().verification == "verified"


def test_a_killed_process_comes_back_and_its_games_go_on_meanwhile(
    two: TrilProcess, database: Database
) -> None:
    started = sum(SERVER_STARTED in line for line in two.output)
    game = two.new_game()
    with join(two.settings, game) as player:
        player.begin()
        player.until_frame(100)
        killed = owner_of(database, game)
        process = psutil.Process(killed)
        process.kill()
        # Until it is gone it may still be given a connection, which a page then tries again.
        process.wait(TIMEOUT_S)
        assert player.close_code() is None
        seen = player.frames[-1].frame
    with join(two.settings, game) as player:
        hello = player.begin()
        assert owner_of(database, game) != killed
        assert seen - hello.frame <= MOST_FRAMES_LOST
        player.until_frame(hello.frame + 10)
        assert player.stop().verification == "verified"
    two.wait_for(SERVER_STARTED, started + 1)
    assert len(two.pids) == 2
    assert killed not in two.pids
    assert any("SIGKILL" in line for line in two.output)


def test_what_changes_in_one_process_is_told_by_both(two: TrilProcess) -> None:
    n_pages = 12
    listening = threading.Barrier(n_pages + 1, timeout=TIMEOUT_S)

    def hear_of_a_name() -> bool:
        with two.http() as http, http.stream("GET", "/api/events") as stream:
            lines = stream.iter_lines()
            assert next(lines).startswith("retry")
            listening.wait()
            for line in lines:
                if line.startswith("data: ") and json.loads(line[6:])["topic"] == "player":
                    return True
        return False

    with ThreadPoolExecutor(n_pages) as pages:
        heard = [pages.submit(hear_of_a_name) for _ in range(n_pages)]
        listening.wait()
        serving = [
            pid
            for pid in two.pids
            if any(c.status == "ESTABLISHED" for c in psutil.Process(pid).net_connections("tcp"))
        ]
        assert len(serving) == 2, "2**-11 that all pages are at one process"
        with two.http() as http:
            assert http.patch("/api/player", json={"name": "Somebody else"}).status_code == 200
        assert all(page.result(TIMEOUT_S) for page in heard)


def test_a_port_is_shared_only_by_those_who_say_so(tmp_path: Path) -> None:
    free = Settings(data=tmp_path, port=0)
    with take_port(free, shares_port=True) as held:
        settings = Settings(data=tmp_path, port=held.getsockname()[1])
        with bind(settings, shares_port=True) as first, bind(settings, shares_port=True) as second:
            with pytest.raises(Unavailable, match="can't be used"):
                bind(settings)
            clients = [socket.create_connection(first.getsockname()) for _ in range(40)]
            counts = []
            for listening in (first, second):
                listening.settimeout(0.2)
                counts.append(_accept_all(listening))
            assert sum(counts) == 40, "the one that only holds the port is given nothing"
            assert min(counts) > 0
            for client in clients:
                client.close()


def _accept_all(listening: socket.socket) -> int:
    n = 0
    while True:
        try:
            listening.accept()[0].close()
        except TimeoutError:
            return n
        n += 1
