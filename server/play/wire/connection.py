"""One page's end of a game: what was sent to it, what it has drawn, which keys it holds."""

from __future__ import annotations

import asyncio
import time
from typing import Protocol

from starlette.websockets import WebSocketDisconnect

from server.play.wire.codec import FrameEncoder
from server.play.wire.protocol import (
    MAX_UNACKNOWLEDGED,
    AckMessage,
    BadMessage,
    FrameMessage,
    InputMessage,
    ServerMessage,
    frame_bytes,
)
from server.play.wire.scene import Scene
from tril.game.controls import Keys

MAX_REASON_CHARACTERS = 60
"""A close reason may have 123 bytes."""

_GONE = (OSError, RuntimeError, WebSocketDisconnect)
"""What a send over a connection raises whose other end has gone."""


class Socket(Protocol):
    """What a connection needs of a WebSocket."""

    async def send_bytes(self, data: bytes) -> None:
        """Send a binary message."""

    async def send_text(self, data: str) -> None:
        """Send a text message."""

    async def close(self, code: int = 1000, reason: str | None = None) -> None:
        """Close the socket."""


class Connection:
    """A page that shows a game.

    At most six frames are on their way to it; while six are, newer ones are left out, so that a
    slow page sees the game late by little instead of ever later.

    Args:
        socket: The accepted WebSocket.
    """

    def __init__(self, socket: Socket) -> None:
        self._socket = socket
        self._lock = asyncio.Lock()
        self._encoder = FrameEncoder()
        self._sent = 0
        self._acknowledged = 0
        self._progress_at = time.monotonic()
        self._held = Keys(0)
        self._pressed = Keys(0)
        self._input_sequence = 0
        self._executed_sequence = 0
        self._on_their_way: dict[int, int] = {}
        self._latencies: list[tuple[int, float]] = []
        self._shown_shots: int | None = None
        self.shown_frame: int | None = None
        self.is_open = True

    @property
    def n_unacknowledged(self) -> int:
        """How many frames were sent and not drawn yet."""
        return self._sent - self._acknowledged

    @property
    def stalled_for_s(self) -> float:
        """For how long the page has drawn nothing although frames wait for it."""
        if self.n_unacknowledged < MAX_UNACKNOWLEDGED:
            return 0.0
        return time.monotonic() - self._progress_at

    def take_keys(self) -> Keys:
        """Return the keys to execute a frame with: those held, and those pressed since the last."""
        keys = self._held | self._pressed
        self.forget_presses()
        self._executed_sequence = self._input_sequence
        return keys

    def forget_presses(self) -> None:
        """Leave out keys that were pressed and let go again while the game stood still."""
        self._pressed = Keys(0)

    def take_latencies(self) -> list[tuple[int, float]]:
        """Return (frame, milliseconds from a key to the frame's drawing) since the last call."""
        taken, self._latencies = self._latencies, []
        return taken

    def receive(self, message: InputMessage | AckMessage) -> None:
        """Take note of held keys or of a drawn frame.

        Raises:
            BadMessage: It acknowledges a frame that was not sent.
        """
        if isinstance(message, InputMessage):
            self._pressed |= message.keys & ~self._held
            self._held = message.keys
            self._input_sequence = message.sequence
        elif message.sequence > self._sent:
            raise BadMessage(
                f"Frame {message.sequence} was acknowledged, but only {self._sent} were sent."
            )
        elif message.sequence > self._acknowledged:
            frames = [
                self._on_their_way.pop(n + 1) for n in range(self._acknowledged, message.sequence)
            ]
            if message.latency_ms is not None:
                self._latencies.append((frames[-1], message.latency_ms))
            self._acknowledged = message.sequence
            self._progress_at = time.monotonic()

    async def show(self, scene: Scene) -> bool:
        """Send a scene unless too many are on their way; returns whether it was sent."""
        async with self._lock:
            if not self.is_open or self.n_unacknowledged >= MAX_UNACKNOWLEDGED:
                return False
            if not self.n_unacknowledged:
                self._progress_at = time.monotonic()
            self._sent += 1
            self.shown_frame = scene.frame
            self._on_their_way[self._sent] = scene.frame
            await self._send(self._written(scene, self._sent))
        return True

    async def tell(self, message: ServerMessage) -> None:
        """Send a text message; nothing happens if the page is gone."""
        async with self._lock:
            await self._send(message.to_json())

    async def close(self, code: int, reason: str = "") -> None:
        """Close the connection; nothing happens if the page is gone."""
        async with self._lock:
            if not self.is_open:
                return
            self.is_open = False
            try:
                await self._socket.close(code, reason[:MAX_REASON_CHARACTERS])
            except _GONE:
                return

    def _written(self, scene: Scene, sequence: int) -> bytes | str:
        """Return the message that shows a scene."""
        shots, self._shown_shots = self._shown_shots, scene.shots
        return frame_bytes(
            FrameMessage(
                sequence,
                scene.frame,
                self._executed_sequence,
                self._encoder.encode(scene.screen),
                scene.formation,
                is_shot=shots is not None and scene.shots > shots,
            )
        )

    async def _send(self, data: bytes | str) -> None:
        if not self.is_open:
            return
        try:
            if isinstance(data, bytes):
                await self._socket.send_bytes(data)
            else:
                await self._socket.send_text(data)
        except _GONE:
            # The page has gone; its reader notices the same and pauses the game.
            self.is_open = False
