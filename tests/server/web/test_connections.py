"""Places and turns of connections, and the answers of those that have none."""

from __future__ import annotations

import asyncio
import json
import re
import socket
from collections.abc import Iterator
from contextlib import ExitStack

import pytest

from server.web import http_protocol, middleware
from server.web.connections import N_SPARE, Connections, Turns
from testsupport.live import TIMEOUT_S, LiveServer, connect_to, cookie, live_server
from testsupport.waiting import wait_until
from testsupport.workplace import Workplace, make_workplace

AT_ONCE = 8
PER_ADDRESS = 4
ELSEWHERE = "127.0.0.2"


def test_a_place_is_free_again_once_it_is_left_and_only_once() -> None:
    connections = Connections(at_once=2, per_address=2)
    first, second = connections.acquire("192.0.2.1"), connections.acquire("192.0.2.2")
    assert first is not None
    assert second is not None
    spare = connections.acquire("192.0.2.3")
    assert spare is not None
    assert spare.is_spare
    first.release()
    first.release()
    again = connections.acquire("192.0.2.3")
    assert again is not None
    assert not again.is_spare
    assert connections.n_served == 2


def test_addresses_of_one_network_count_as_one_and_proxies_as_many() -> None:
    connections = Connections(100, per_address=1, is_proxy=lambda address: address == "192.0.2.9")
    for address, is_spare in (
        ("2001:db8:1:2::1", False),
        ("2001:db8:1:2:ffff::9", True),
        ("2001:db8:1:3::1", False),
        ("192.0.2.9", False),
        ("192.0.2.9", False),
        ("192.0.2.1", False),
        ("192.0.2.1", True),
    ):
        slot = connections.acquire(address)
        assert slot is not None
        assert slot.is_spare == is_spare, address


def test_spare_places_end_too() -> None:
    connections = Connections(at_once=1, per_address=1)
    slots = [connections.acquire("192.0.2.1") for _ in range(1 + N_SPARE)]
    assert all(slot is not None for slot in slots)
    assert connections.acquire("192.0.2.1") is None


def test_addresses_take_turns_and_nobody_waits_while_nothing_is_to_do() -> None:
    done: list[str] = []

    async def take() -> None:
        turns = Turns(every_s=0.001)
        for name in ("a1", "a2", "a3", "b1", "b2"):
            turns.take(name[0], lambda name=name: done.append(name))  # type: ignore[misc]
        assert done == ["a1"], "the first has its turn at once"
        turns.take("c", lambda: done.append("c"))
        while len(done) < 6:
            await asyncio.sleep(0.001)

    asyncio.run(take())
    assert done == ["a1", "a2", "b1", "c", "a3", "b2"]


def test_a_turn_that_fails_does_not_end_the_others() -> None:
    done: list[str] = []

    def fail() -> None:
        raise RuntimeError("as it happens")

    async def take() -> None:
        asyncio.get_running_loop().set_exception_handler(lambda _loop, _context: None)
        turns = Turns(every_s=0.001)
        turns.take("a", lambda: None)
        turns.take("a", fail)
        turns.take("a", lambda: done.append("after"))
        while not done:
            await asyncio.sleep(0.001)

    asyncio.run(take())


@pytest.fixture(scope="module")
def small(tmp_path_factory: pytest.TempPathFactory) -> Iterator[LiveServer]:
    made = make_workplace(tmp_path_factory.mktemp("small") / "data")
    made.database.close()
    with live_server(
        made.settings.data, max_connections=AT_ONCE, max_connections_per_address=PER_ADDRESS
    ) as server:
        server.http.headers["Connection"] = "close"
        server.http.get("/api/player")
        yield server


def connected(server: LiveServer, stack: ExitStack, address: str = "127.0.0.1") -> socket.socket:
    return stack.enter_context(
        socket.create_connection(("127.0.0.1", server.settings.port), TIMEOUT_S, (address, 0))
    )


def ask(client: socket.socket, server: LiveServer, path: str, more: str = "") -> tuple[int, bytes]:
    client.sendall(
        f"GET {path} HTTP/1.1\r\nHost: 127.0.0.1:{server.settings.port}\r\n"
        f"Cookie: {cookie(server.settings)}\r\n{more}Connection: close\r\n\r\n".encode()
    )
    with client.makefile("rb") as answer:
        whole = answer.read()
    return int(whole.split(b" ", 2)[1]), whole


def served(server: LiveServer) -> int:
    """Return what a new connection of an address of its own is answered."""
    with ExitStack() as stack:
        return ask(connected(server, stack, "127.0.0.9"), server, "/api/player")[0]


@pytest.mark.parametrize("half", [b"", b"GET /api/he", b"GET / HTTP/1.1\r\nX-"])
def test_half_requests_of_one_address_leave_room_for_others(small: LiveServer, half: bytes) -> None:
    with ExitStack() as stack:
        for _ in range(PER_ADDRESS):
            connected(small, stack, ELSEWHERE).sendall(half)
        wait_until(lambda: ask(connected(small, stack, ELSEWHERE), small, "/api/player")[0] == 503)
        assert served(small) == 200
    wait_until(lambda: served(small) == 200)


def test_health_is_answered_while_every_place_is_taken(small: LiveServer) -> None:
    with ExitStack() as stack:
        for number in range(AT_ONCE):
            connected(small, stack, f"127.0.1.{number}")
        wait_until(lambda: served(small) == 503)
        status, answer = ask(connected(small, stack), small, "/api/health")
        assert status == 200
        assert answer.endswith(b'{"status":"ok"}')
        status, answer = ask(connected(small, stack), small, "/api/player")
        assert status == 503
        assert b"Too many connections" in answer
        assert b"retry-after" in answer.lower()
        assert b"content-security-policy" in answer.lower()
        upgrade = "Upgrade: websocket\r\nConnection: Upgrade\r\n"
        assert ask(connected(small, stack), small, "/api/games/1/stream", upgrade)[0] == 503
    wait_until(lambda: served(small) == 200)


def test_a_websocket_keeps_its_place_until_it_closes(small: LiveServer) -> None:
    games = [small.new_game() for _ in range(PER_ADDRESS)]
    with ExitStack() as stack:
        for game in games:
            stack.enter_context(connect_to(small.settings, game["stream_path"]))
        client = stack.enter_context(
            socket.create_connection(("127.0.0.1", small.settings.port), TIMEOUT_S)
        )
        assert ask(client, small, "/api/player")[0] == 503
        assert served(small) == 200
    with ExitStack() as stack:
        wait_until(lambda: ask(connected(small, stack), small, "/api/player")[0] == 200)


@pytest.fixture
def hasty(workplace: Workplace, monkeypatch: pytest.MonkeyPatch) -> Iterator[LiveServer]:
    monkeypatch.setattr(http_protocol, "HEAD_TIMEOUT_S", 0.3)
    monkeypatch.setattr(middleware, "BODY_TIMEOUT_S", 0.3)
    with live_server(workplace.settings.data) as server:
        yield server


def test_a_body_that_never_comes_is_not_waited_for(hasty: LiveServer) -> None:
    head = (
        f"POST /api/behaviours HTTP/1.1\r\nHost: {hasty.authority}\r\n"
        f"Cookie: {cookie(hasty.settings)}\r\nContent-Type: application/json\r\n"
        "Content-Length: 1000\r\n\r\n{"
    )
    with ExitStack() as stack:
        client = connected(hasty, stack)
        client.sendall(head.encode())
        with client.makefile("rb") as answer:
            whole = answer.read()
    assert whole.startswith(b"HTTP/1.1 408")
    assert b"took too long" in whole


def test_the_rest_of_a_body_that_was_refused_is_not_waited_for(hasty: LiveServer) -> None:
    head = (
        f"POST /api/behaviours HTTP/1.1\r\nHost: {hasty.authority}\r\n"
        "Content-Type: application/json\r\nContent-Length: 1000\r\n\r\n{"
    )
    with ExitStack() as stack:
        client = connected(hasty, stack)
        client.sendall(head.encode())
        assert client.recv(65536).startswith(b"HTTP/1.1 401")
        wait_until(lambda: is_closed_after(client, b" "))  # never idle


def is_closed_after(client: socket.socket, data: bytes) -> bool:
    """Send something; return whether the other end has closed the connection."""
    client.settimeout(0.02)
    try:
        client.sendall(data)
        return client.recv(1024) == b""
    except TimeoutError:
        return False
    except ConnectionError:
        return True


@pytest.mark.parametrize(
    ("sent", "status"),
    [
        (b"nonsense\r\n\r\n", 400),
        (b"GET / HTTP/1.1\r\nHost: a\r\nContent-Length: x\r\n\r\n", 400),
        (b"GET / HTTP/1.1\r\nX: " + b"a" * (http_protocol.MAX_HEAD_BYTES + 1), 431),
    ],
)
def test_what_is_no_http_is_refused_with_a_problem_and_security_headers(
    hasty: LiveServer, sent: bytes, status: int
) -> None:
    with ExitStack() as stack:
        client = connected(hasty, stack)
        client.sendall(sent)
        with client.makefile("rb") as answer:
            head, _, body = answer.read().partition(b"\r\n\r\n")
    assert head.startswith(f"HTTP/1.1 {status} ".encode())
    assert b"content-security-policy:" in head.lower()
    assert b"x-content-type-options: nosniff" in head.lower()
    assert json.loads(body)["detail"]


@pytest.mark.parametrize("signed_in", [True, False])
def test_handshakes_carry_security_headers_too(hasty: LiveServer, signed_in: bool) -> None:
    path = "/api/games/1/stream" if signed_in else "/nothing"
    with ExitStack() as stack:
        client = connected(hasty, stack)
        client.sendall(
            f"GET {path} HTTP/1.1\r\nHost: {hasty.authority}\r\nUpgrade: websocket\r\n"
            "Connection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
            "Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\n\r\n".encode()
        )
        answer = client.recv(65536)
    assert re.match(rb"HTTP/1.1 (101|403)", answer)
    assert b"x-content-type-options: nosniff" in answer.lower()
