"""What careless and hostile clients do: ``python -m benchmarks.play.support.attacks NAME``.

Every attack goes to 127.0.0.1 and is bounded in connections and time. It prints what it came to:
how often it was tried, and how often the server answered, refused or closed. Attackers connect from
127.0.0.2, so that the server can tell them from the players, who come from 127.0.0.1.
"""

from __future__ import annotations

import argparse
import asyncio
import base64
import json
import os
import secrets
import subprocess
import sys
import time
import uuid
from collections import Counter
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import asynccontextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from benchmarks.play.support.pages import owners_cookie
from server.play.wire.protocol import InputMessage
from testsupport.protocol import client_bytes
from testsupport.space_invaders import Keys
from tril.exchange.formats.recording_file import dump_recording
from tril.games.atari.starts import AtariStart
from tril.games.space_invaders import SPACE_INVADERS
from tril.recording import Recording
from tril.settings import Settings

HOST = "127.0.0.1"
FROM = "127.0.0.2"
NICENESS = 10
"""Attackers have machines of their own."""

AFTER_REFUSAL_S = 0.05
UPLOAD_BYTES = 16 * 1024 * 1024
TEXT, BINARY = 1, 2
_GONE = (OSError, EOFError, asyncio.IncompleteReadError)

Stream = tuple[asyncio.StreamReader, asyncio.StreamWriter]


@dataclass
class Attacker:
    """A client that counts what it came to.

    Attributes:
        settings: The server's settings.
        until: When it ends, by the monotonic clock.
        counts: How often what happened.
    """

    settings: Settings
    until: float
    counts: Counter[str] = field(default_factory=Counter)

    def goes_on(self) -> bool:
        """Return whether there is time left."""
        return time.monotonic() < self.until

    @asynccontextmanager
    async def connected(self) -> AsyncIterator[Stream]:
        """Open a connection for the block; that it breaks ends the block."""
        self.counts["tried"] += 1
        try:
            reader, writer = await asyncio.open_connection(
                HOST, self.settings.port, local_addr=(FROM, 0)
            )
        except OSError:
            self.counts["not connected"] += 1
            await asyncio.sleep(AFTER_REFUSAL_S)
            return
        try:
            yield reader, writer
        except _GONE:
            self.counts["closed"] += 1
            await asyncio.sleep(AFTER_REFUSAL_S)
        finally:
            writer.transport.abort()

    def head(
        self, method: str, path: str, length: int | None = None, signed_in: bool = True
    ) -> bytes:
        """Return the head of a request."""
        lines = [f"{method} {path} HTTP/1.1", f"Host: {HOST}:{self.settings.port}"]
        if signed_in:
            lines.append(f"Cookie: {owners_cookie(self.settings.data, self.settings.port)}")
        if length is not None:
            lines += ["Content-Type: application/json", f"Content-Length: {length}"]
        return ("\r\n".join(lines) + "\r\nConnection: close\r\n\r\n").encode()

    async def ask(
        self, method: str, path: str, body: bytes | None = None, signed_in: bool = True
    ) -> bytes:
        """Send a request; returns the whole answer, nothing if there was none."""
        answer = b""
        async with self.connected() as (reader, writer):
            length = None if body is None else len(body)
            writer.write(self.head(method, path, length, signed_in) + (body or b""))
            answer = await asyncio.wait_for(reader.read(), 60)
            self.counts[_status(answer)] += 1
        return answer

    async def new_game(self) -> str | None:
        """Create a game; returns its stream's path."""
        answer = await self.ask("POST", "/api/games", b'{"behaviour_id": 1}')
        with suppress(ValueError, KeyError, IndexError):
            path: str = json.loads(answer.split(b"\r\n\r\n", 1)[1])["stream_path"]
            return path
        await asyncio.sleep(AFTER_REFUSAL_S)
        return None

    async def upgrade(self, stream: Stream, path: str) -> bool:
        """Open a WebSocket on a connection; returns whether the server agreed."""
        reader, writer = stream
        key = base64.b64encode(secrets.token_bytes(16)).decode()
        writer.write(
            f"GET {path} HTTP/1.1\r\nHost: {HOST}:{self.settings.port}\r\nUpgrade: websocket\r\n"
            f"Connection: Upgrade\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket-Key: {key}\r\n"
            f"Cookie: {owners_cookie(self.settings.data, self.settings.port)}\r\n\r\n".encode()
        )
        head = await reader.readuntil(b"\r\n\r\n")
        self.counts[_status(head)] += 1
        return head.startswith(b"HTTP/1.1 101")


def _status(answer: bytes) -> str:
    return answer[9:12].decode("ascii", "replace") if answer else "closed"


def message(kind: int, data: bytes, first: int = 0x80) -> bytes:
    """Return a WebSocket frame whose mask is zero."""
    if len(data) < 126:
        return bytes((first | kind, 0x80 | len(data), 0, 0, 0, 0)) + data
    return bytes((first | kind, 0xFE)) + len(data).to_bytes(2, "big") + bytes(4) + data


async def only_computing(attacker: Attacker) -> None:
    """Take a core and send nothing, to tell apart what attacks take from the processor alone."""
    while attacker.goes_on():
        attacker.counts["rounds"] += 1
        sum(range(100_000))


async def requests_with_cookie(attacker: Attacker) -> None:
    """Read and write as fast as answers come, 60 at a time."""

    async def go_on(number: int) -> None:
        while attacker.goes_on():
            if number % 3:
                await attacker.ask("GET", "/api/behaviours/1/recordings")
            else:
                await attacker.ask("PATCH", "/api/recordings/1", b'{"notes": "a burst"}')

    await asyncio.gather(*map(go_on, range(60)))


async def requests_without_cookie(attacker: Attacker) -> None:
    """Ask without being signed in, 60 at a time."""

    async def go_on(_number: int) -> None:
        while attacker.goes_on():
            await attacker.ask("GET", "/api/behaviours", signed_in=False)

    await asyncio.gather(*map(go_on, range(60)))


async def inputs(attacker: Attacker) -> None:
    """Send inputs to a game as fast as the connection takes them, from four pages."""
    many = message(BINARY, client_bytes(InputMessage(Keys.FIRE, 1))) * 200

    async def go_on(_number: int) -> None:
        path = await attacker.new_game()
        if path is None:
            return
        while attacker.goes_on():
            async with attacker.connected() as stream:
                if await attacker.upgrade(stream, path):
                    while attacker.goes_on():
                        stream[1].write(many)
                        await stream[1].drain()

    await asyncio.gather(*map(go_on, range(4)))


async def slow_readers(attacker: Attacker) -> None:
    """Begin 20 games and read nothing of them."""

    async def go_on(_number: int) -> None:
        path = await attacker.new_game()
        if path is None:
            return
        async with attacker.connected() as stream:
            if await attacker.upgrade(stream, path):
                stream[1].transport.pause_reading()  # type: ignore[attr-defined]
                while attacker.goes_on():
                    stream[1].write(message(TEXT, b'{"type": "ready"}'))
                    await asyncio.sleep(1.0)

    await asyncio.gather(*map(go_on, range(20)))


async def endless_heads(attacker: Attacker) -> None:
    """Send headers without an end over 20 connections."""

    async def go_on(number: int) -> None:
        part = b"a" * 8192 if number % 2 else b"X-Header: value\r\n" * 480
        while attacker.goes_on():
            async with attacker.connected() as (_, writer):
                writer.write(b"GET /api/health HTTP/1.1\r\nX-Long: ")
                while attacker.goes_on():
                    writer.write(part)
                    await writer.drain()

    await asyncio.gather(*map(go_on, range(20)))


async def half_requests(attacker: Attacker) -> None:
    """Hold 400 connections, half of them within a head and half within a body."""

    async def go_on(number: int) -> None:
        while attacker.goes_on():
            async with attacker.connected() as (reader, writer):
                if number % 2:
                    writer.write(b"GET /api/health HTTP/1.1\r\nX-")
                else:
                    writer.write(attacker.head("PATCH", "/api/recordings/1", 1000) + b"{")
                with suppress(TimeoutError):
                    answer = await asyncio.wait_for(
                        reader.read(), max(0.0, attacker.until - time.monotonic())
                    )
                    attacker.counts[_status(answer)] += 1
                    await asyncio.sleep(AFTER_REFUSAL_S)
                    continue
                attacker.counts["open in the end"] += 1

    await asyncio.gather(*map(go_on, range(400)))


async def uploads(attacker: Attacker) -> None:
    """Upload 16 MiB of nothing, 40 at a time, half of them to a route without uploads."""
    body = b" " * UPLOAD_BYTES

    async def go_on(number: int) -> None:
        path = "/api/behaviours/1/recordings/import" if number % 2 else "/api/behaviours"
        while attacker.goes_on():
            await attacker.ask("POST", path, body)
            await asyncio.sleep(AFTER_REFUSAL_S)

    await asyncio.gather(*map(go_on, range(40)))


async def imports(attacker: Attacker) -> None:
    """Import 50 recordings at a time, which are replayed, over 4 connections."""
    rng = np.random.default_rng(0)

    def line() -> bytes:
        actions = bytes(rng.integers(0, 6, 600, np.uint8))
        start = AtariStart(int(rng.integers(64)))
        return json.dumps(dump_recording(Recording(SPACE_INVADERS, start, actions))).encode()

    async def go_on(_number: int) -> None:
        while attacker.goes_on():
            body = b"\n".join(line() for _ in range(50))
            await attacker.ask("POST", "/api/behaviours/2/recordings/import", body)

    await asyncio.gather(*map(go_on, range(4)))


async def rewinds(attacker: Attacker) -> None:
    """Play some frames and go back, in a loop, from four pages."""
    rewind, release, ready = (
        message(TEXT, json.dumps({"type": kind}).encode())
        for kind in ("rewind", "release", "ready")
    )

    async def read(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        """Acknowledge frames; count the recordings that were kept."""
        sequence = 0
        while True:
            kind, length = await reader.readexactly(2)
            if length == 126:
                length = int.from_bytes(await reader.readexactly(2), "big")
            elif length == 127:
                length = int.from_bytes(await reader.readexactly(8), "big")
            data = await reader.readexactly(length)
            if kind & 15 == BINARY:
                sequence += 1
                writer.write(message(BINARY, bytes((2, 0, 0, 0)) + sequence.to_bytes(4, "little")))
            elif kind & 15 == TEXT and b'"rewound"' in data[:40]:
                attacker.counts["rewound"] += 1

    async def go_on(_number: int) -> None:
        path = await attacker.new_game()
        if path is None:
            return
        while attacker.goes_on():
            async with attacker.connected() as (reader, writer):
                if not await attacker.upgrade((reader, writer), path):
                    return
                reading = asyncio.create_task(read(reader, writer))
                writer.write(ready)
                while attacker.goes_on() and not reading.done():
                    await asyncio.sleep(0.35)
                    writer.write(rewind)
                    await asyncio.sleep(0.1)
                    writer.write(release)
                reading.cancel()
                with suppress(asyncio.CancelledError):
                    await reading

    await asyncio.gather(*map(go_on, range(4)))


async def unknown_games(attacker: Attacker) -> None:
    """Join games that do not exist, 40 at a time."""

    async def go_on(_number: int) -> None:
        while attacker.goes_on():
            async with attacker.connected() as stream:
                path = f"/api/games/{uuid.uuid4()}/stream"
                if await attacker.upgrade(stream, path):
                    await stream[0].read(1024)

    await asyncio.gather(*map(go_on, range(40)))


BAD_FRAMES = (
    bytes((0x80 | BINARY, 0xFF)) + (2**40).to_bytes(8, "big") + bytes(4),  # a terabyte to come
    bytes((0x80 | BINARY, 0xFE)) + (60_000).to_bytes(2, "big") + bytes(4),
    message(BINARY, b"x" * 2000),
    message(3, b"reserved opcode"),
    message(TEXT, b"\xff\xfe"),
    message(TEXT, b"{" * 100),
    message(BINARY, b"\x07" * 8),
    bytes((0x80 | TEXT, 2)) + b"{}",  # without a mask
    message(TEXT, b"{", first=0) + message(0, b"{", first=0) * 50,  # parts without an end
    message(9, b"ping" * 20) * 20,
    b"\x00" * 100,
)
"""Frames that no page sends."""


async def bad_frames(attacker: Attacker) -> None:
    """Send frames that break the protocol, 20 at a time."""

    async def go_on(number: int) -> None:
        path, at = None, number
        while attacker.goes_on():
            path = path or await attacker.new_game()
            if path is None:
                continue
            async with attacker.connected() as stream:
                if await attacker.upgrade(stream, path):
                    at += 1
                    stream[1].write(BAD_FRAMES[at % len(BAD_FRAMES)])
                    with suppress(TimeoutError):
                        async with asyncio.timeout(1.0):
                            while await stream[0].read(65536):
                                pass
                        attacker.counts["closed after it"] += 1
                else:
                    path = None

    await asyncio.gather(*map(go_on, range(20)))


async def event_streams(attacker: Attacker) -> None:
    """Open 400 event streams while changes happen."""

    async def listen(_number: int) -> None:
        while attacker.goes_on():
            async with attacker.connected() as (reader, writer):
                writer.write(attacker.head("GET", "/api/events"))
                head = await reader.readuntil(b"\r\n\r\n")
                attacker.counts[_status(head)] += 1
                with suppress(TimeoutError):
                    async with asyncio.timeout(max(0.0, attacker.until - time.monotonic())):
                        while await reader.read(65536):
                            pass
                    await asyncio.sleep(AFTER_REFUSAL_S)

    async def change() -> None:
        number = 0
        while attacker.goes_on():
            number += 1
            notes = json.dumps({"notes": f"change {number}"}).encode()
            await attacker.ask("PATCH", "/api/recordings/1", notes)
            await asyncio.sleep(0.1)

    await asyncio.gather(*map(listen, range(400)), change())


def _repeated(name: str, what: str, request_of: Callable[[Attacker], bytes]) -> Attack:
    """Return an attack that sends a request again and again, from four connections at a time."""

    async def attack(attacker: Attacker) -> None:
        request = request_of(attacker)

        async def go_on(_number: int) -> None:
            while attacker.goes_on():
                async with attacker.connected() as (reader, writer):
                    writer.write(request)
                    answer = await asyncio.wait_for(reader.read(4096), 60)
                    attacker.counts[_status(answer)] += 1

        await asyncio.gather(*map(go_on, range(4)))

    attack.__name__, attack.__doc__ = name, what
    return attack


def _with_lines(head: bytes, *lines: bytes) -> bytes:
    return head.removesuffix(b"\r\n") + b"".join(line + b"\r\n" for line in lines) + b"\r\n"


def _stranger(attacker: Attacker, method: str, path: str, length: int | None = None) -> bytes:
    return attacker.head(method, path, length, signed_in=False)


Attack = Callable[[Attacker], Awaitable[None]]

_FIELDS = b"a=1&" * 250_000
_KEYS = b"{" + b",".join(b'"%d":1' % number for number in range(90_000)) + b"}"

PARSED: tuple[Attack, ...] = (
    _repeated(
        "forms",
        "Send a megabyte of fields as the form of an invitation.",
        lambda a: _stranger(a, "POST", "/join", len(_FIELDS)) + _FIELDS,
    ),
    _repeated(
        "queries",
        "Ask with a query of 15,000 fields.",
        lambda a: _stranger(a, "GET", "/?" + "a=1&" * 15_000),
    ),
    _repeated(
        "many_lines",
        "Send a head of 15,000 lines.",
        lambda a: _with_lines(_stranger(a, "GET", "/"), *[b"a:"] * 15_000),
    ),
    _repeated(
        "cookies",
        "Send 4,000 backslashes between quotes as a cookie, of 60,000 that are possible.",
        lambda a: _with_lines(_stranger(a, "GET", "/"), b'Cookie: a="' + b"\\" * 4000 + b'"'),
    ),
    _repeated(
        "chunks",
        "Send a quarter of a megabyte in chunks of a byte.",
        lambda a: (
            _with_lines(_stranger(a, "POST", "/join"), b"Transfer-Encoding: chunked")
            + b"1\r\na\r\n" * 43_000
        ),
    ),
    _repeated(
        "without_waiting",
        "Send 1,000 requests without waiting for answers.",
        lambda a: _stranger(a, "GET", "/").replace(b"Connection: close\r\n", b"") * 1000,
    ),
    _repeated(
        "handshakes",
        "Offer 4,000 subprotocols for a stream.",
        lambda a: _with_lines(
            _stranger(a, "GET", "/api/games/x/stream").replace(b": close", b": Upgrade"),
            b"Upgrade: websocket",
            b"Sec-WebSocket-Version: 13",
            b"Sec-WebSocket-Key: YWFhYWFhYWFhYWFhYWFhYQ==",
            b"Sec-WebSocket-Protocol: " + b"a," * 3900 + b"a",
        ),
    ),
    _repeated(
        "wrong_fields",
        "Send JSON with 90,000 fields that are not known, signed in.",
        lambda a: a.head("POST", "/api/games", len(_KEYS)) + _KEYS,
    ),
)
"""What takes a server that parses it in its event loop long."""

ATTACKS: dict[str, Attack] = {
    attack.__name__: attack
    for attack in (
        only_computing,
        requests_with_cookie,
        requests_without_cookie,
        inputs,
        slow_readers,
        endless_heads,
        half_requests,
        uploads,
        imports,
        rewinds,
        unknown_games,
        bad_frames,
        event_streams,
        *PARSED,
    )
}


class AttackProcess:
    """An attack in a process of its own.

    Args:
        settings: The server's settings.
        name: Which attack.
        seconds: How long.
    """

    def __init__(self, settings: Settings, name: str, seconds: float) -> None:
        self._limit_s = seconds + 90
        words = ["--data", str(settings.data), "--port", str(settings.port)]
        self._process = subprocess.Popen(
            [
                sys.executable,
                "-m",
                "benchmarks.play.support.attacks",
                name,
                "--seconds",
                str(seconds),
                *words,
            ],
            stdout=subprocess.PIPE,
            text=True,
        )

    def counts(self) -> dict[str, int]:
        """Wait for its end; returns what it came to."""
        try:
            output, _ = self._process.communicate(timeout=self._limit_s)
        except subprocess.TimeoutExpired:
            self._process.kill()
            output, _ = self._process.communicate()
        found: dict[str, int] = json.loads(output or "{}")
        return found


async def _attack(settings: Settings, name: str, seconds: float) -> Counter[str]:
    attacker = Attacker(settings, time.monotonic() + seconds)
    # Some attacks wait for answers that a server need not give.
    with suppress(TimeoutError):
        await asyncio.wait_for(ATTACKS[name](attacker), seconds + 5)
    return attacker.counts


def main() -> None:
    """Attack and print the counts."""
    parser = argparse.ArgumentParser()
    parser.add_argument("attack", choices=ATTACKS)
    parser.add_argument("--data", type=Path, required=True)
    parser.add_argument("--port", type=int, required=True)
    parser.add_argument("--seconds", type=float, required=True)
    arguments = parser.parse_args()
    os.nice(NICENESS)
    settings = Settings(data=arguments.data, port=arguments.port)
    print(json.dumps(asyncio.run(_attack(settings, arguments.attack, arguments.seconds))))


if __name__ == "__main__":
    main()
