"""What is answered while PostgreSQL can't be reached, and once it can be again."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import psycopg
import pytest
from psycopg import sql
from sqlalchemy import make_url
from websockets.exceptions import ConnectionClosed

from server.play.wire.protocol import Close
from testsupport.databases import CHOICE
from testsupport.live import TIMEOUT_S, LiveServer, connect_to, live_server
from testsupport.postgres import ROLE, cluster
from testsupport.workplace import make_workplace


@pytest.fixture
def server(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[LiveServer]:
    cluster()
    monkeypatch.setenv(CHOICE, "postgresql")
    workplace = make_workplace(tmp_path / "data")
    workplace.database.close()
    with live_server(workplace.settings.data) as running:
        yield running


@contextmanager
def away(server: LiveServer) -> Iterator[None]:
    """End every connection with the server's database, and take no new ones."""
    name = make_url(server.settings.application_url).database
    assert name is not None
    host = str(cluster().folder)
    with psycopg.connect(host=host, user=ROLE, dbname="postgres", autocommit=True) as connection:
        allow = sql.SQL("ALTER DATABASE {} ALLOW_CONNECTIONS {}")
        connection.execute(allow.format(sql.Identifier(name), False))
        try:
            query = "SELECT pg_terminate_backend(pid) FROM pg_stat_activity WHERE datname = %s"
            connection.execute(query, (name,))
            yield
        finally:
            connection.execute(allow.format(sql.Identifier(name), True))


def test_requests_are_answered_503_and_say_what_to_do(server: LiveServer) -> None:
    notes = {"notes": "before"}
    assert server.http.patch("/api/recordings/1", json=notes).is_success
    with away(server):
        asked = [
            server.http.get("/api/recordings/1"),
            server.http.patch("/api/recordings/1", json={"notes": "while it is away"}),
            server.http.get("/api/runs"),
        ]
        assert [answer.status_code for answer in asked] == [503] * 3
        assert "database can't be reached" in asked[0].json()["detail"]
        assert server.http.get("/api/health").is_success
    assert server.http.get("/api/recordings/1").json()["notes"] == "before"


def test_who_is_not_known_yet_is_asked_to_try_again(server: LiveServer) -> None:
    game = server.new_game()
    server.services.access.forget()
    with away(server):
        assert server.http.get("/api/runs").status_code == 503
        with connect_to(
            server.settings, game["stream_path"], server.http.headers["Cookie"]
        ) as socket:
            with pytest.raises(ConnectionClosed) as closed:
                socket.recv(timeout=TIMEOUT_S)
            assert closed.value.rcvd is not None
            assert closed.value.rcvd.code == Close.TRY_AGAIN_LATER
    with server.play(game) as player:
        player.begin()
