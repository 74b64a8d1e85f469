"""The connection to a page: flow control, acknowledgements, keys held."""

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

MAX_REASON_CHARACTERS = 60
"""A close reason is limited to 123 bytes."""

GONE = (OSError, RuntimeError, WebSocketDisconnect)
"""What a send raises if the other end has gone."""


class Socket(Protocol):
    """The part of a WebSocket that a connection uses."""

    async def send_bytes(self, data: bytes) -> None:
        """Send a binary message."""

    async def send_text(self, data: str) -> None:
        """Send a text message."""

    async def close(self, code: int = 1000, reason: str | None = None) -> None:
        """Close the socket."""


class Connection:
    """A page that shows a game.

    At most six frames are in flight; while six are, newer ones are dropped, so that a slow page
    lags by a bounded time.

    Args:
        socket: The accepted WebSocket.

    Attributes:
        shown_frame: The game's frame that was sent last.
        is_open: False once the page has gone or was closed.
    """

    def __init__(self, socket: Socket) -> None:
        self._socket = socket
        self._lock = asyncio.Lock()
        self._encoder: FrameEncoder | None = None
        self._sent = 0
        self._acknowledged = 0
        self._progress_at = time.monotonic()
        self._held = 0
        self._tapped = 0
        self._input_sequence = 0
        self._executed_sequence = 0
        self._in_flight: dict[int, int] = {}
        self._latencies: list[tuple[int, float]] = []
        self._shown_counted: int | None = None
        self.shown_frame: int | None = None
        self.is_open = True

    @property
    def n_unacknowledged(self) -> int:
        """Frames that were sent and not acknowledged."""
        return self._sent - self._acknowledged

    @property
    def stalled_for_s(self) -> float:
        """Seconds since the last acknowledgement while the window of frames is full, else 0."""
        if self.n_unacknowledged < MAX_UNACKNOWLEDGED:
            return 0.0
        return time.monotonic() - self._progress_at

    @property
    def holds_button(self) -> bool:
        """Whether a button is held, or was tapped since the last frame."""
        return bool(self._held | self._tapped)

    def take_buttons(self) -> int:
        """Return the buttons for the next frame, as bits: held, or tapped since the last frame."""
        keys = self._held | self._tapped
        self.discard_taps()
        self._executed_sequence = self._input_sequence
        return keys

    def discard_taps(self) -> None:
        """Ignore keys that were tapped while the game was not running."""
        self._tapped = 0

    def take_latencies(self) -> list[tuple[int, float]]:
        """Return and clear (frame, ms from a key's event to the frame's drawing)."""
        latencies, self._latencies = self._latencies, []
        return latencies

    def receive(self, message: InputMessage | AckMessage) -> None:
        """Process an input or an acknowledgement.

        Raises:
            BadMessage: The message acknowledges a frame that was not sent.
        """
        if isinstance(message, InputMessage):
            self._tapped |= message.buttons & ~self._held
            self._held = message.buttons
            self._input_sequence = message.sequence
        elif message.sequence > self._sent:
            raise BadMessage(
                f"Frame {message.sequence} was acknowledged, but only {self._sent} were sent."
            )
        elif message.sequence > self._acknowledged:
            frames = [
                self._in_flight.pop(n + 1) for n in range(self._acknowledged, message.sequence)
            ]
            if message.latency_ms is not None:
                self._latencies.append((frames[-1], message.latency_ms))
            self._acknowledged = message.sequence
            self._progress_at = time.monotonic()

    async def show(self, scene: Scene) -> bool:
        """Send a scene unless the page is behind or gone; returns whether it was sent."""
        async with self._lock:
            if not self.is_open or self.n_unacknowledged >= MAX_UNACKNOWLEDGED:
                return False
            if not self.n_unacknowledged:
                self._progress_at = time.monotonic()
            self._sent += 1
            self.shown_frame = scene.frame
            self._in_flight[self._sent] = scene.frame
            await self._send(self._encode(scene, self._sent))
        return True

    async def send(self, message: ServerMessage) -> None:
        """Send a text message, unless the page has gone."""
        async with self._lock:
            await self._send(message.to_json())

    async def close(
        self, code: int, reason: str = "", last_message: ServerMessage | None = None
    ) -> None:
        """Close the connection after a last message, unless the page has gone."""
        async with self._lock:
            if last_message is not None:
                await self._send(last_message.to_json())
            if not self.is_open:
                return
            self.is_open = False
            try:
                await self._socket.close(code, reason[:MAX_REASON_CHARACTERS])
            except GONE:
                return

    def _encode(self, scene: Scene, sequence: int) -> bytes | str:
        counted, self._shown_counted = self._shown_counted, scene.counted
        if self._encoder is None:
            self._encoder = FrameEncoder(scene.screen.shape)
        return frame_bytes(
            FrameMessage(
                sequence,
                scene.frame,
                self._executed_sequence,
                self._encoder.encode(scene.screen),
                scene.marks,
                has_counted=counted is not None and scene.counted > counted,
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
        except GONE:
            # The task that receives notices the same, and pauses the game.
            self.is_open = False
