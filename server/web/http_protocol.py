"""How long and how large the head of a request may be."""

from __future__ import annotations

import asyncio

import h11
from uvicorn.protocols.http.h11_impl import H11Protocol

MAX_HEAD_BYTES = 64 * 1024
"""Browsers send the cookies of every server on this host, whatever its port."""

HEAD_TIMEOUT_S = 20.0


class HttpProtocol(H11Protocol):
    """uvicorn's HTTP/1.1, which also closes connections on which a request never gets complete.

    Of uvicorn's two parsers, h11 bounds heads and trailers (h11_max_incomplete_event_size), and
    httptools reads on for ever. h11 takes 0.2 ms longer for a request.
    """

    _timeout: asyncio.TimerHandle

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        """Expect a request."""
        super().connection_made(transport)
        self._expect_head()

    def data_received(self, data: bytes) -> None:
        """Take in a part of a request."""
        super().data_received(data)
        if self.conn.their_state is not h11.IDLE:
            self._timeout.cancel()
        elif self._timeout.cancelled():
            self._expect_head()

    def connection_lost(self, exc: Exception | None) -> None:
        """Forget the timeout."""
        self._timeout.cancel()
        super().connection_lost(exc)

    def _expect_head(self) -> None:
        self._timeout = self.loop.call_later(HEAD_TIMEOUT_S, self.transport.close)
