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
from server.web.connections import Connections, Place
from server.web.middleware import PUBLIC_PATHS, SecurityHeaders
from server.web.problems import problem
from server.web.security_headers import ENCODED_SECURITY_HEADERS

MAX_HEAD_BYTES = 64 * 1024
"""Browsers send the cookies of every server on this host, whatever its port."""

HEAD_TIMEOUT_S = 20.0

SPARE_TIMEOUT_S = 2.0
"""The same for connections that have no place."""


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


class HttpProtocol(H11Protocol):
    """uvicorn's HTTP/1.1, which bounds what connections take.

    A connection needs a place; without one it gets 503, except for the health check. What is
    received is taken in in turns. Connections on which a request never gets complete are closed.

    Of uvicorn's two parsers, h11 bounds heads and trailers (h11_max_incomplete_event_size), and
    httptools reads on for ever. h11 takes 0.2 ms longer for a request.
    """

    config: ServerConfig
    _place: Place | None = None
    _timeout: asyncio.TimerHandle | None = None

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        """Take a place and expect a request."""
        super().connection_made(transport)
        self._received = bytearray()
        address = self.client[0] if self.client else ""
        self._place = self.config.connections.enter(address)
        if self._place is None:
            transport.abort()
            return
        if self._place.is_spare:
            self.app = SecurityHeaders(_OnlyHealth(self.app))
            self.timeout_keep_alive = 0
        self._watch()

    def data_received(self, data: bytes) -> None:
        """Take in a part of a request when it is this connection's turn."""
        if self._place is None:
            return
        waits = bool(self._received)
        self._received += data
        self.flow.pause_reading()
        if not waits:
            self.config.connections.turns.take(self._place.address, self._take_in)

    def connection_lost(self, exc: Exception | None) -> None:
        """Leave the place."""
        self._stop_watching()
        if self._place is not None:
            self._place.leave()
        super().connection_lost(exc)

    def handle_websocket_upgrade(self, event: h11.Request) -> None:
        """Hand the connection and its place to the WebSocket."""
        super().handle_websocket_upgrade(event)
        self._stop_watching()
        websocket = self.transport.get_protocol()
        websocket.place, self._place = self._place, None  # type: ignore[attr-defined]

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
            why = "The head of the request is too large." if status == 431 else msg
            answer = problem(status, why)
            headers = [*answer.raw_headers, *ENCODED_SECURITY_HEADERS, (b"connection", b"close")]
            for part in (
                h11.Response(status_code=status, headers=headers),
                h11.Data(data=bytes(answer.body)),
                h11.EndOfMessage(),
            ):
                self.transport.write(self.conn.send(part) or b"")
        self.transport.close()

    def _should_upgrade(self) -> bool:
        is_spare = self._place is not None and self._place.is_spare
        return not is_spare and super()._should_upgrade()

    def _take_in(self) -> None:
        received, self._received = bytes(self._received), bytearray()
        if self.transport.is_closing():
            return
        self.flow.resume_reading()
        super().data_received(received)
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
            is_spare = self._place is not None and self._place.is_spare
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
