"""Heads of requests that never end or never come."""

from __future__ import annotations

import itertools
import socket
from collections.abc import Iterator

import pytest

from server.web import http_protocol
from server.web.http_protocol import MAX_HEAD_BYTES
from testsupport.live import TIMEOUT_S, LiveServer, live_server
from testsupport.workplace import Workplace
from tril.store.changes import note_change

MANY_BYTES = 512 * MAX_HEAD_BYTES
"""More than fits into the buffers of both ends."""


def connected(server: LiveServer) -> socket.socket:
    return socket.create_connection(("127.0.0.1", server.settings.port), TIMEOUT_S)


@pytest.mark.parametrize(
    ("begin", "more"),
    [
        (b"GET /api/health HTTP/1.1\r\nX-Long: ", b"a" * 8192),
        (b"GET /api/health HTTP/1.1\r\n", b"X-Header: value\r\n" * 500),
        (b"GET /", b"a" * 8192),
        (
            b"POST /api/behaviours HTTP/1.1\r\nHost: 127.0.0.1\r\n"
            b"Transfer-Encoding: chunked\r\n\r\n0\r\n",
            b"X-Trailer: value\r\n" * 500,
        ),
    ],
    ids=["one header", "many headers", "a path", "trailers"],
)
def test_a_head_without_an_end_is_not_read_for_ever(
    live: LiveServer, begin: bytes, more: bytes
) -> None:
    with connected(live) as client:
        client.sendall(begin)
        with pytest.raises(ConnectionError):
            client.sendall(more * (MANY_BYTES // len(more)))
    assert live.http.get("/api/health").status_code == 200


def test_a_head_as_long_as_a_browser_sends_is_read(live: LiveServer) -> None:
    answer = live.http.get("/api/health", headers={"X-Long": "a" * (MAX_HEAD_BYTES - 4096)})
    assert answer.status_code == 200


@pytest.fixture
def hasty(workplace: Workplace, monkeypatch: pytest.MonkeyPatch) -> Iterator[LiveServer]:
    monkeypatch.setattr(http_protocol, "HEAD_TIMEOUT_S", 0.2)
    with live_server(workplace.settings.data) as server:
        yield server


def _is_ended(client: socket.socket) -> bool:
    """Wait for the end of a connection: closed, or reset where bytes came after its end."""
    try:
        return client.recv(1024) == b""
    except ConnectionResetError:
        return True


@pytest.mark.parametrize(
    "begin", [b"", b"GET /api/he", b"GET /api/health HTTP/1.1\r\nHost: 127.0.0.1\r\nX-"]
)
def test_a_head_that_never_comes_is_not_waited_for(hasty: LiveServer, begin: bytes) -> None:
    with connected(hasty) as client:
        client.sendall(begin)
        assert _is_ended(client)


def test_the_second_head_of_a_connection_is_not_waited_for_either(hasty: LiveServer) -> None:
    whole = f"GET /api/health HTTP/1.1\r\nHost: 127.0.0.1:{hasty.settings.port}\r\n\r\n".encode()
    with connected(hasty) as client:
        client.sendall(whole)
        received = b""
        while b"ok" not in received.partition(b"\r\n\r\n")[2]:
            part = client.recv(4096)
            assert part, received
            received += part
        client.sendall(whole[:20])
        assert _is_ended(client)


def test_streams_outlive_the_timeout(hasty: LiveServer) -> None:
    with hasty.http.stream("GET", "/api/events") as stream, hasty.play(hasty.new_game()) as player:
        lines = stream.iter_lines()
        assert next(lines).startswith("retry")
        player.begin()
        player.until_frame(60)  # a second
        with hasty.database.writing() as session:
            note_change(session, "run", "abc")
        assert any("abc" in line for line in itertools.islice(lines, 10))
