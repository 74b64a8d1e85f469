"""What is bounded before anything of a request is parsed in the event loop."""

from __future__ import annotations

import socket

import httpx2
import pytest

from server.web.http_protocol import (
    MAX_HEAD_LINES,
    MAX_PATH_BYTES,
    MAX_QUERY_BYTES,
    MAX_QUERY_FIELDS,
)
from server.web.middleware import MAX_PARTICIPANTS_BODY_BYTES, MAX_STRANGERS_BODY_BYTES
from server.web.problems import MAX_ERRORS
from server.web.sign_in import MAX_FIELDS
from testsupport.live import TIMEOUT_S, LiveServer, cookie
from testsupport.visitors import cookie_of
from tril.store import players
from tril.store.models import MembershipRow, Role

HALF_HEAD = 30 * 1024


def exchange(server: LiveServer, request: bytes) -> bytes:
    """Send bytes and return all that is answered until the server closes."""
    with socket.create_connection(("127.0.0.1", server.settings.port), TIMEOUT_S) as client:
        client.sendall(request)
        answer = b""
        while part := client.recv(65536):
            answer += part
        return answer


def head(server: LiveServer, target: str, *lines: str, method: str = "GET") -> bytes:
    all_lines = [f"{method} {target} HTTP/1.1", f"Host: {server.authority}", *lines]
    return ("\r\n".join([*all_lines, "Connection: close"]) + "\r\n\r\n").encode("latin-1")


def status(answer: bytes) -> int:
    return int(answer.split(b" ", 2)[1])


@pytest.mark.parametrize(
    ("target", "lines", "expected"),
    [
        ("/api/health", ["a:"] * MAX_HEAD_LINES, 431),
        ("/" + "a" * MAX_PATH_BYTES, [], 414),
        ("/api/health?" + "a" * (MAX_QUERY_BYTES + 1), [], 414),
        ("/api/health?" + "a&" * MAX_QUERY_FIELDS, [], 414),
        ("/api/health?" + "a=1&" * 100, [], 200),
        ("/api/health", ["Origin: http://[:::]"], 403),
        ("/api/health", ["Origin: http://[" + ":" * HALF_HEAD + "]"], 403),
        ("/api/health", ["Accept-Language: " + "a," * HALF_HEAD], 200),
        ("/api/health", ["Accept-Encoding: " + "a," * HALF_HEAD], 200),
        ("/", ["Accept-Language: " + "a," * HALF_HEAD], 401),
    ],
    ids=[
        "many lines",
        "a long path",
        "a long query",
        "many fields",
        "fields that nobody reads",
        "an origin that is none",
        "a long origin",
        "many languages",
        "many codings",
        "many languages of a page",
    ],
)
def test_heads_are_bounded(live: LiveServer, target: str, lines: list[str], expected: int) -> None:
    assert status(exchange(live, head(live, target, *lines))) == expected


def test_a_body_has_to_declare_its_length(live: LiveServer) -> None:
    request = head(live, "/join", "Transfer-Encoding: chunked", method="POST")
    answer = exchange(live, request + b"1\r\na\r\n")
    assert status(answer) == 411
    assert b"Content-Length" in answer


def test_requests_sent_without_waiting_are_all_answered_in_order(live: LiveServer) -> None:
    one = f"GET /api/health HTTP/1.1\r\nHost: {live.authority}\r\n\r\n".encode()
    answer = exchange(live, one * 20 + head(live, "/api/nothing"))
    codes = [part.split(b" ", 1)[0] for part in answer.split(b"HTTP/1.1 ")[1:]]
    assert codes == [b"200"] * 20 + [b"401"]


@pytest.mark.parametrize("path", ["/", "/api/health", "/api/behaviours"])
def test_the_cookies_of_other_servers_are_not_parsed(live: LiveServer, path: str) -> None:
    # http.cookies takes minutes for these before Python 3.11.10.
    others = 'a="' + "\\" * HALF_HEAD + '"; b="' + "\\101" * 1000 + '"'
    own = cookie(live.settings)
    for cookies in (f"{others}; {own}", f"{own}; {others}", f"{others}; {own}; c=1"):
        assert status(exchange(live, head(live, path, f"Cookie: {cookies}"))) == 200
    assert status(exchange(live, head(live, path, f"Cookie: {others}"))) in {200, 401}


@pytest.mark.parametrize("name", ["Sec-WebSocket-Protocol", "Sec-WebSocket-Extensions"])
def test_lists_in_a_handshake_are_not_parsed(live: LiveServer, name: str) -> None:
    # Beyond websockets' 8 KiB for a line.
    handshake = (
        "Upgrade: websocket",
        "Sec-WebSocket-Version: 13",
        "Sec-WebSocket-Key: YWFhYWFhYWFhYWFhYWFhYQ==",
        f"{name}: {'a,' * 5000}a",
    )
    request = head(live, "/api/games/x/stream", *handshake)
    with socket.create_connection(("127.0.0.1", live.settings.port), TIMEOUT_S) as client:
        client.sendall(request.replace(b"Connection: close", b"Connection: Upgrade"))
        assert status(client.recv(1024)) == 101


def test_a_form_of_a_stranger_is_bounded(live: LiveServer) -> None:
    form = {"Content-Type": "application/x-www-form-urlencoded"}
    with httpx2.Client(base_url=str(live.http.base_url), timeout=TIMEOUT_S) as stranger:
        for body, expected in (
            (b"a=1&" * 250_000, 413),
            (b"a" * (MAX_STRANGERS_BODY_BYTES + 1), 413),
            (b"a=1&" * (MAX_FIELDS + 1), 404),
        ):
            answer = stranger.post("/join", content=body, headers=form)
            assert answer.status_code == expected


def test_fields_beyond_the_bound_are_not_read(live: LiveServer) -> None:
    wish = {"name": "A class", "role": "participant", "behaviour_id": 1}
    link: str = live.http.post("/api/invitations", json=wish).json()["path"]
    with httpx2.Client(base_url=str(live.http.base_url), timeout=TIMEOUT_S) as stranger:
        assert stranger.get(f"{link}&a=1").status_code == 200
        assert stranger.get(link + "&a=1" * MAX_FIELDS).status_code == 404


def test_the_body_of_a_participant_is_bounded(live: LiveServer) -> None:
    with live.database.writing() as session:
        person = players.add(session, "Ada", Role.PARTICIPANT)
        session.add(MembershipRow(behaviour_id=1, player_id=person.id))
        session.flush()
        player_id = person.id
    headers = {"Cookie": "=".join(cookie_of(live.settings, player_id))}
    name = b'{"name": "Ada"}'
    for path in ("/api/player", "/api/recordings/1", "/api/behaviours/1/ranking"):
        answer = live.http.patch(
            path, content=name.ljust(MAX_PARTICIPANTS_BODY_BYTES + 1), headers=headers
        )
        assert answer.status_code == 413
    answer = live.http.patch(
        "/api/player", content=name.ljust(MAX_PARTICIPANTS_BODY_BYTES), headers=headers
    )
    assert answer.status_code != 413


def test_a_request_with_many_errors_lists_the_first(live: LiveServer) -> None:
    answer = live.http.post("/api/games", json={str(number): 1 for number in range(1000)})
    assert answer.status_code == 422
    assert len(answer.json()["errors"]) == MAX_ERRORS


def test_a_ranking_with_many_errors_is_refused_at_the_first(live: LiveServer) -> None:
    body = {"base_revision": 0, "tiers": [["a"] * 100] * 100}
    answer = live.http.put("/api/behaviours/1/ranking", json=body)
    assert answer.status_code == 422
    assert len(answer.json()["errors"]) == 1
