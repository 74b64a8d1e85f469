"""How requests and WebSockets arrive: sizes and times of heads, places and turns of connections."""

from __future__ import annotations

import asyncio
import sys
from typing import Any

import h11
import uvicorn
from starlette.types import Receive, Scope, Send
from uvicorn.protocols.http.h11_impl import H11Protocol

from server.concurrency import RETRY_AFTER_S
from server.web.connections import Connections, ConnectionSlot
from server.web.middleware import PUBLIC_PATHS, SecurityHeaders
from server.web.problems import problem
from server.web.security_headers import ENCODED_SECURITY_HEADERS

MAX_HEAD_BYTES = 64 * 1024
"""Browsers send the cookies of every server on this host, whatever its port."""

MAX_HEAD_LINES = 100
"""As Apache; each line costs the event loop 25 microseconds, and 64 KiB have room for 16,000."""

MAX_PATH_BYTES = 1024

MAX_QUERY_BYTES = 16 * 1024

MAX_QUERY_FIELDS = 512
"""An export names up to 500 recordings."""

HEAD_TIMEOUT_S = 20.0

SPARE_TIMEOUT_S = 2.0
"""The same for connections that have no slot."""


class ServerConfig(uvicorn.Config):
    """uvicorn's configuration, and the connections of the process.

    Args:
        app: The application.
        connections: Counts the process's connections.
        **options: uvicorn's.
    """

    def __init__(self, app: Any, connections: Connections, **options: Any) -> None:
        super().__init__(app, **options)
        self.connections = connections


_REFUSALS = {
    411: "Send the body with its length (Content-Length) instead of in chunks.",
    414: "The address of the request is too long.",
    431: "The head of the request is too large.",
}


_UNUSED_IN_HANDSHAKES = frozenset(
    {b"connection", b"sec-websocket-extensions", b"sec-websocket-protocol"}
)


class _BoundedParser(h11.Connection):
    """h11's parser, which refuses what would take the event loop long to parse.

    h11 bounds the bytes of a head, not its lines, and neither the number of chunks of a body: a
    quarter of a megabyte in chunks of one byte takes half a second. Browsers send none.
    """

    def next_event(self) -> h11.Event | type[h11.NEED_DATA] | type[h11.PAUSED]:
        """Parse the next event; raises RemoteProtocolError with the status to answer."""
        if self.their_state is h11.IDLE:
            head = self.trailing_data[0].partition(b"\r\n\r\n")[0]
            if head.count(b"\n") > MAX_HEAD_LINES:
                raise h11.RemoteProtocolError("many lines", error_status_hint=431)
        event = super().next_event()
        if isinstance(event, h11.Request):
            path, _, query = event.target.partition(b"?")
            if (
                len(path) > MAX_PATH_BYTES
                or len(query) > MAX_QUERY_BYTES
                or query.count(b"&") >= MAX_QUERY_FIELDS
            ):
                raise h11.RemoteProtocolError("a long target", error_status_hint=414)
            if any(name == b"transfer-encoding" for name, _ in event.headers):
                raise h11.RemoteProtocolError("a body in chunks", error_status_hint=411)
        return event


class HttpProtocol(H11Protocol):
    """uvicorn's HTTP/1.1, which bounds what connections take.

    A connection needs a slot; without one it gets 503, except for the health check. What is
    received is taken in in turns, also requests that a client sends without waiting for answers.
    Connections on which a request never gets complete are closed.

    Of uvicorn's two parsers, h11 bounds heads and trailers (h11_max_incomplete_event_size), and
    httptools reads on for ever. h11 takes 0.2 ms longer for a request.
    """

    config: ServerConfig
    _slot: ConnectionSlot | None = None
    _timeout: asyncio.TimerHandle | None = None
    _has_turn = False

    def __init__(self, config: ServerConfig, *args: Any, **kwargs: Any) -> None:
        super().__init__(config, *args, **kwargs)
        self.conn = _BoundedParser(h11.SERVER, MAX_HEAD_BYTES)

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        """Acquire a slot and expect a request."""
        super().connection_made(transport)
        self._received = bytearray()
        address = self.client[0] if self.client else ""
        self._slot = self.config.connections.acquire(address)
        if self._slot is None:
            transport.abort()
            return
        if self._slot.is_spare:
            self.app = SecurityHeaders(_OnlyHealth(self.app))
            self.timeout_keep_alive = 0
        self._watch()

    def data_received(self, data: bytes) -> None:
        """Take in a part of a request when it is this connection's turn."""
        if self._slot is None:
            return
        waits = bool(self._received)
        self._received += data
        self.flow.pause_reading()
        if not waits:
            self.config.connections.turns.take(self._slot.address, self._process_received)

    def connection_lost(self, exc: Exception | None) -> None:
        """Free the slot."""
        self._stop_watching()
        if self._slot is not None:
            self._slot.release()
        super().connection_lost(exc)

    def handle_websocket_upgrade(self, event: h11.Request) -> None:
        """Hand the connection and its slot to the WebSocket."""
        # Of the lists in a handshake none is of use: no subprotocol and no extension is spoken.
        headers = [
            (name, value) for name, value in self.headers if name not in _UNUSED_IN_HANDSHAKES
        ]
        self.headers = [*headers, (b"connection", b"Upgrade")]
        super().handle_websocket_upgrade(event)
        self._stop_watching()
        websocket = self.transport.get_protocol()
        websocket.slot, self._slot = self._slot, None  # type: ignore[attr-defined]

    def on_response_complete(self) -> None:
        """Expect what is left of the request, or the next one."""
        super().on_response_complete()
        if not self.transport.is_closing():
            self._watch()

    def send_400_response(self, msg: str) -> None:
        """Answer what is no HTTP, unless an answer is under way, and close."""
        # uvicorn calls this while it handles h11's error, which knows the status.
        error = sys.exc_info()[1]
        status = error.error_status_hint if isinstance(error, h11.RemoteProtocolError) else 400
        if self.conn.our_state in {h11.IDLE, h11.SEND_RESPONSE}:
            answer = problem(status, _REFUSALS.get(status, msg))
            headers = [*answer.raw_headers, *ENCODED_SECURITY_HEADERS, (b"connection", b"close")]
            for part in (
                h11.Response(status_code=status, headers=headers),
                h11.Data(data=bytes(answer.body)),
                h11.EndOfMessage(),
            ):
                self.transport.write(self.conn.send(part) or b"")
        self.transport.close()

    def handle_events(self) -> None:
        """Parse what was received; the next request that is here already in its turn."""
        if self._has_turn:
            super().handle_events()
        elif self._slot is not None and self.conn.trailing_data[0] and not self._received:
            self.config.connections.turns.take(self._slot.address, self._process_received)

    def _should_upgrade(self) -> bool:
        is_spare = self._slot is not None and self._slot.is_spare
        return not is_spare and super()._should_upgrade()

    def _process_received(self) -> None:
        received, self._received = bytes(self._received), bytearray()
        if self.transport.is_closing():
            return
        self.flow.resume_reading()
        self._has_turn = True
        try:
            if received:
                super().data_received(received)
            else:
                super().handle_events()
        finally:
            self._has_turn = False
        if self.transport.get_protocol() is self:
            self._watch()

    def _watch(self) -> None:
        """Time what the client owes: a head, or the rest of a body that nobody reads any more."""
        is_owed = self.conn.their_state is h11.IDLE or (
            self.conn.their_state is h11.SEND_BODY and self.conn.our_state is h11.DONE
        )
        if not is_owed:
            self._stop_watching()
        elif self._timeout is None:
            is_spare = self._slot is not None and self._slot.is_spare
            timeout_s = SPARE_TIMEOUT_S if is_spare else HEAD_TIMEOUT_S
            self._timeout = self.loop.call_later(timeout_s, self.transport.close)

    def _stop_watching(self) -> None:
        if self._timeout is not None:
            self._timeout.cancel()
            self._timeout = None


class _OnlyHealth:
    """Answers the health check, and 503 otherwise."""

    def __init__(self, app: Any) -> None:
        self._app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["path"] in PUBLIC_PATHS:
            await self._app(scope, receive, send)
            return
        answer = problem(
            503,
            "Too many connections to this server are open. Close other tabs, or try again in a "
            "few seconds.",
        )
        answer.headers["Retry-After"] = str(RETRY_AFTER_S)
        await answer(scope, receive, send)
