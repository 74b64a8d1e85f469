"""Simulated pages, which speak the protocol, acknowledge every frame and hold random keys.

They parse WebSocket frames themselves and do not decode pictures, so that many of them take little
CPU time from the server.
"""

from __future__ import annotations

import asyncio
import base64
import json
import re
import secrets
import struct
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass
from functools import cache, partial
from pathlib import Path
from typing import Any

import httpx2
import numpy as np

from server.play.wire.protocol import InputMessage
from testsupport.live import TIMEOUT_S, cookie
from testsupport.protocol import client_bytes
from testsupport.space_invaders import Keys
from tril.settings import Settings

HOST = "127.0.0.1"
NEW_KEYS_EVERY_FRAMES = 20
_TEXT, _BINARY, _CLOSE, _PING, _PONG = 1, 2, 8, 9, 10
_ACK = struct.Struct("<BBHI")
_SEQUENCE = struct.Struct("<4xI")
_JPEG_SEQUENCE = re.compile(rb'"sequence": (\d+)')


@dataclass
class Counts:
    """Counts of what pages received and sent.

    Attributes:
        frames: Frames received.
        bytes_down: Bytes from the server, WebSocket headers included.
        bytes_up: Bytes to the server, likewise.
        games: Games that came to their end.
        refused: Games that could not be begun or joined.
        broken: Connections that broke.
    """

    frames: int = 0
    bytes_down: int = 0
    bytes_up: int = 0
    games: int = 0
    refused: int = 0
    broken: int = 0

    def __add__(self, other: Counts) -> Counts:
        mine, others = asdict(self), asdict(other)
        return Counts(**{name: mine[name] + others[name] for name in mine})

    def __sub__(self, earlier: Counts) -> Counts:
        mine, others = asdict(self), asdict(earlier)
        return Counts(**{name: mine[name] - others[name] for name in mine})


@cache
def owners_cookie(data: Path, port: int) -> str:
    """Sign one browser of the owner in and return its Cookie header.

    Once for each process: it writes to the database, which keeps an event loop, and the server,
    waiting.
    """
    return cookie(Settings(data=data, port=port))


class Page(asyncio.Protocol):
    """One connection to a game.

    Args:
        settings: Where the server is.
        path: The stream's path.
        counts: The counts to add to.
        rng: Chooses keys.
        on_frame: Called with every frame's sequence.
        cookie_header: Who plays; the owner by default.

    Attributes:
        acknowledges: Whether frames are acknowledged.
        over: Set when the connection has closed; True if the game came to its end.
        transport: The connection.
    """

    def __init__(
        self,
        settings: Settings,
        path: str,
        counts: Counts,
        rng: np.random.Generator,
        on_frame: Callable[[int], None] = lambda _sequence: None,
        cookie_header: str | None = None,
    ) -> None:
        self._settings = settings
        self._cookie = cookie_header or owners_cookie(settings.data, settings.port)
        self._path = path
        self._counts = counts
        self._rng = rng
        self.acknowledges = True
        self._on_frame = on_frame
        self._buffer = bytearray()
        self._is_open = False
        self._ended = False
        self._inputs = 0
        self._until_new_keys = 0
        self.over: asyncio.Future[bool] = asyncio.get_running_loop().create_future()
        self.transport: asyncio.Transport

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Request the upgrade to a WebSocket."""
        assert isinstance(transport, asyncio.Transport)
        self.transport = transport
        key = base64.b64encode(secrets.token_bytes(16)).decode()
        transport.write(
            f"GET {self._path} HTTP/1.1\r\nHost: {HOST}:{self._settings.port}\r\n"
            "Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
            f"Sec-WebSocket-Key: {key}\r\n"
            f"Cookie: {self._cookie}\r\n\r\n".encode()
        )

    def connection_lost(self, exc: Exception | None) -> None:
        """Resolve ``over``."""
        if not self._ended:
            self._counts.broken += 1
        if not self.over.done():
            self.over.set_result(self._ended)

    def data_received(self, data: bytes) -> None:
        """Parse what was received."""
        self._buffer += data
        if not self._is_open:
            end = self._buffer.find(b"\r\n\r\n")
            if end < 0:
                return
            if not self._buffer.startswith(b"HTTP/1.1 101"):
                self.transport.close()
                return
            del self._buffer[: end + 4]
            self._is_open = True
        else:
            self._counts.bytes_down += len(data)
        self._read()

    def say(self, message: dict[str, Any]) -> None:
        """Send a text message."""
        self._send(_TEXT, json.dumps(message).encode())

    def _read(self) -> None:
        buffer, at = self._buffer, 0
        while len(buffer) >= at + 2:
            length, begin = buffer[at + 1], at + 2
            if length == 126:
                begin += 2
                length = int.from_bytes(buffer[at + 2 : begin], "big")
            elif length == 127:
                begin += 8
                length = int.from_bytes(buffer[at + 2 : begin], "big")
            if len(buffer) < begin + length:
                break
            self._take(buffer[at] & 15, bytes(buffer[begin : begin + length]))
            at = begin + length
        del buffer[:at]

    def _take(self, kind: int, data: bytes) -> None:
        if kind == _BINARY:
            self._see(_SEQUENCE.unpack_from(data)[0])
        elif kind == _TEXT and data.startswith(b'{"frame"'):
            found = _JPEG_SEQUENCE.search(data, 0, 60)
            assert found is not None
            self._see(int(found[1]))
        elif kind == _TEXT:
            self._hear(json.loads(data)["type"])
        elif kind == _PING:
            self._send(_PONG, data)
        elif kind == _CLOSE:
            self.transport.close()

    def _see(self, sequence: int) -> None:
        self._counts.frames += 1
        self._on_frame(sequence)
        if self.acknowledges:
            self._send(_BINARY, _ACK.pack(2, 0, 0, sequence))
        self._until_new_keys -= 1
        if self._until_new_keys < 0:
            self._until_new_keys = NEW_KEYS_EVERY_FRAMES
            self._inputs += 1
            keys = Keys(int(self._rng.integers(3))) | Keys.FIRE
            self._send(_BINARY, client_bytes(InputMessage(keys, self._inputs)))

    def _hear(self, kind: str) -> None:
        if kind == "hello":
            self.say({"type": "ready"})
        elif kind == "ended":
            self._ended = True
            self._counts.games += 1

    def _send(self, kind: int, data: bytes) -> None:
        # A mask of zeros is valid and needs not be applied.
        assert len(data) < 126
        message = bytes((0x80 | kind, 0x80 | len(data), 0, 0, 0, 0)) + data
        self._counts.bytes_up += len(message)
        self.transport.write(message)


async def new_game(http: httpx2.AsyncClient, counts: Counts) -> str | None:
    """Create a game; returns its stream's path, None if there is no place."""
    answer = await http.post("/api/games", json={"behaviour_id": 1})
    if answer.status_code == 503:
        counts.refused += 1
        return None
    answer.raise_for_status()
    path: str = answer.json()["stream_path"]
    return path


def client_of(settings: Settings) -> httpx2.AsyncClient:
    """Return a signed-in client that opens a connection for each request."""
    return httpx2.AsyncClient(
        base_url=f"http://{HOST}:{settings.port}",
        headers={
            "Cookie": owners_cookie(settings.data, settings.port),
            "Connection": "close",
        },
        timeout=TIMEOUT_S,
    )


async def join(settings: Settings, path: str, make: Callable[[str], Page]) -> Page:
    """Connect a page to a game's stream."""
    loop = asyncio.get_running_loop()
    _, page = await loop.create_connection(lambda: make(path), HOST, settings.port)
    return page


async def arrive(settings: Settings, link: str, name: str) -> float:
    """Come by an invitation as a browser does, begin a game, and leave.

    Args:
        settings: The server's settings.
        link: The invitation's path.
        name: Who comes.

    Returns:
        Seconds from opening the link to the game's first frame.
    """
    began_s, counts = time.monotonic(), Counts()
    base_url = f"http://{HOST}:{settings.port}"
    async with httpx2.AsyncClient(base_url=base_url, timeout=TIMEOUT_S) as http:
        asked = (await http.get(link)).raise_for_status()
        (signed,) = re.findall(r'name="invitation" value="([^"]+)"', asked.text)
        joined = await http.post("/join", data={"invitation": signed, "name": name})
        page = (await http.get(joined.headers["Location"])).raise_for_status()
        files = set(re.findall(r'(?:src|href)="(/[^"]+)"', page.text))
        await asyncio.gather(*(http.get(file) for file in files))
        path = await new_game(http, counts)
        if path is None:
            raise RuntimeError("There was no place for a game.")
        cookies = "; ".join(f"{key}={value}" for key, value in http.cookies.items())
    seen = asyncio.Event()
    rng = np.random.default_rng(0)
    page_of = partial(
        Page, settings, path, counts, rng, lambda _sequence: seen.set(), cookie_header=cookies
    )
    _, playing = await asyncio.get_running_loop().create_connection(page_of, HOST, settings.port)
    await asyncio.wait_for(seen.wait(), TIMEOUT_S)
    playing.transport.abort()
    return time.monotonic() - began_s


async def play_on_and_on(
    settings: Settings, counts: Counts, rng: np.random.Generator, stream: str
) -> None:
    """Play one game after the other.

    Args:
        settings: The server's settings.
        counts: The counts to add to.
        rng: Chooses keys.
        stream: "stream" for Tril's protocol, "jpeg" for CrowdPlay's.
    """
    async with client_of(settings) as http:
        while True:
            try:
                path = await new_game(http, counts)
            except httpx2.TransportError:
                counts.broken += 1
                path = None
            if path is None:
                await asyncio.sleep(1.0)
                continue
            path = f"{path.rsplit('/', 1)[0]}/{stream}"
            page = await join(settings, path, lambda p: Page(settings, p, counts, rng))
            await page.over
