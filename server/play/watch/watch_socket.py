"""The WebSocket of a page that watches, shared by several games."""

from __future__ import annotations

import asyncio

from starlette.websockets import WebSocket

from server.play.wire.connection import GONE, MAX_REASON_CHARACTERS
from server.play.wire.protocol import Close, Message


class WatchSocket:
    """Sends the messages of several games over one WebSocket.

    Args:
        websocket: The accepted WebSocket.

    Attributes:
        is_open: False once the page has gone or was closed.
    """

    def __init__(self, websocket: WebSocket) -> None:
        self._websocket = websocket
        self._lock = asyncio.Lock()
        self.is_open = True

    async def send_message(self, message: Message) -> None:
        """Send a text message, unless the page has gone."""
        async with self._lock:
            await self._send(message)

    async def send_frame(self, lane: int, data: bytes) -> None:
        """Send a lane's FRAME; raises as the WebSocket if the page has gone."""
        async with self._lock:
            await self._websocket.send_bytes(bytes((lane,)) + data)

    async def close(self, code: Close, reason: str, last_message: Message | None = None) -> None:
        """Close the socket after a last message, unless the page has gone."""
        async with self._lock:
            if last_message is not None:
                await self._send(last_message)
            if not self.is_open:
                return
            self.is_open = False
            try:
                await self._websocket.close(code, reason[:MAX_REASON_CHARACTERS])
            except GONE:
                return

    async def _send(self, message: Message) -> None:
        if not self.is_open:
            return
        try:
            await self._websocket.send_text(message.to_json())
        except GONE:
            self.is_open = False


class LaneSocket:
    """The part of a watching page's WebSocket that shows one of its games.

    Args:
        socket: The page's socket.
        lane: The game's place, from 0.
    """

    def __init__(self, socket: WatchSocket, lane: int) -> None:
        self._socket = socket
        self._lane = lane

    async def send_bytes(self, data: bytes) -> None:
        """Send a FRAME."""
        await self._socket.send_frame(self._lane, data)

    async def send_text(self, data: str) -> None:
        """Refuse: text messages are sent by the page's socket."""
        raise NotImplementedError(data)

    async def close(self, code: int = 1000, reason: str | None = None) -> None:
        """Leave the page's socket open."""
