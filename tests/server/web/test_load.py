"""Many requests at once, and uploads that wait."""

from __future__ import annotations

import json
import socket
from collections import Counter
from collections.abc import Iterator
from contextlib import ExitStack
from itertools import cycle

import httpx2
import pytest

from testsupport.live import TIMEOUT_S, cookie
from testsupport.processes import TrilProcess, server_process
from testsupport.workplace import make_workplace
from tril.store.database import create_database

N_REQUESTS = 60


@pytest.fixture(scope="module")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[TrilProcess]:
    made = make_workplace(tmp_path_factory.mktemp("load") / "data")
    made.database.close()
    with server_process(made.settings.data) as running:
        yield running


def request(server: TrilProcess, method: str, path: str, body: object = None) -> bytes:
    content = b"" if body is None else json.dumps(body).encode()
    head = (
        f"{method} {path} HTTP/1.1\r\nHost: 127.0.0.1:{server.settings.port}\r\n"
        f"Cookie: {cookie(server.settings)}\r\nConnection: close\r\n"
        f"Content-Type: application/json\r\nContent-Length: {len(content)}\r\n\r\n"
    )
    return head.encode() + content


def status(client: socket.socket) -> int:
    with client.makefile("rb") as answer:
        return int(answer.read().split(b" ", 2)[1])


def test_sixty_requests_at_once_are_all_answered_and_reads_while_writes_wait(
    server: TrilProcess,
) -> None:
    expected = (
        ("PATCH", "/api/player", {"name": "Ada"}, 200),
        ("GET", "/api/behaviours/1/recordings", None, 200),
        ("PATCH", "/api/recordings/1", {"notes": "one of sixty"}, 200),
        ("GET", "/api/behaviours/999/ranking", None, 404),
    )
    database = create_database(server.settings.application_url)
    with ExitStack() as stack:
        stack.callback(database.close)
        clients = [
            stack.enter_context(
                socket.create_connection(("127.0.0.1", server.settings.port), TIMEOUT_S)
            )
            for _ in range(N_REQUESTS)
        ]
        answers: Counter[tuple[str, str, int]] = Counter()

        def take_answers(method: str) -> None:
            for client, (sent, path, _, _) in zip(clients, cycle(expected), strict=False):
                if sent == method:
                    answers[method, path, status(client)] += 1

        # Signing in writes, too, so the requests are made before.
        requests = [request(server, method, path, body) for method, path, body, _ in expected]
        with database.writing() as session:
            session.connection()  # takes the lock, so that all writes are under way at once
            for client, content in zip(clients, cycle(requests), strict=False):
                client.sendall(content)
            health = httpx2.get(f"{server.base_url}/api/health", timeout=TIMEOUT_S)
            assert health.status_code == 200
            take_answers("GET")
        take_answers("PATCH")
    each = N_REQUESTS // len(expected)
    assert answers == {(method, path, code): each for method, path, _, code in expected}


def test_an_upload_is_read_only_in_its_turn(server: TrilProcess) -> None:
    body = b'{"format": "unknown"}'
    head = (
        f"POST /api/behaviours/1/recordings/import HTTP/1.1\r\n"
        f"Host: 127.0.0.1:{server.settings.port}\r\nCookie: {cookie(server.settings)}\r\n"
        f"Connection: close\r\nContent-Length: {len(body)}\r\nExpect: 100-continue\r\n\r\n"
    ).encode()
    address = ("127.0.0.1", server.settings.port)
    with (
        socket.create_connection(address, TIMEOUT_S) as first,
        socket.create_connection(address, TIMEOUT_S) as second,
    ):
        first.sendall(head)
        assert b"100 Continue" in first.recv(1024), "it is asked for its body"
        second.sendall(head)
        for _ in range(3):  # by then the second is waiting
            httpx2.get(f"{server.base_url}/api/health", timeout=TIMEOUT_S)
        second.setblocking(False)
        with pytest.raises(BlockingIOError):
            second.recv(1024)
        second.settimeout(TIMEOUT_S)
        first.sendall(body)
        assert status(first) == 200
        assert b"100 Continue" in second.recv(1024)
        second.sendall(body)
        assert status(second) == 200
