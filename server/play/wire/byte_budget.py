"""Limits what a page may send, where its bytes arrive.

A message costs the event loop about 10 microseconds, so that a socket that sends as fast as it can
would take all of it, whatever is then done with the messages.
"""

from __future__ import annotations

import logging
from http import HTTPStatus
from typing import Any

from uvicorn.protocols.websockets.websockets_sansio_impl import WebSocketsSansIOProtocol
from websockets.http11 import Response

from server.web.connections import ConnectionSlot
from server.web.security_headers import ENCODED_SECURITY_HEADERS, SECURITY_HEADERS

_LOG = logging.getLogger(__name__)

RATE_BYTES_PER_S = 8 * 1024
"""An INPUT and an ACK for each of 60 frames a second are 1,680 bytes/s."""
BURST_BYTES = 16 * 1024
"""About what a page that sends 60 inputs a second piles up until its pings time out (20 s)."""


class TokenBucket:
    """A token bucket: ``rate`` tokens per second, of which at most ``burst`` accumulate.

    Args:
        rate: Tokens added per second.
        burst: Capacity; the bucket starts full.
        now_s: The current time, monotonic.
    """

    def __init__(self, rate: float, burst: float, now_s: float) -> None:
        self._rate = rate
        self._burst = self._tokens = burst
        self._refilled_s = now_s

    def take(self, n: int, now_s: float) -> bool:
        """Take n tokens; returns False, and takes none, if there are fewer."""
        refill = self._rate * (now_s - self._refilled_s)
        self._tokens = min(self._burst, self._tokens + refill)
        self._refilled_s = now_s
        if n > self._tokens:
            return False
        self._tokens -= n
        return True


class BudgetedWebSocketProtocol(WebSocketsSansIOProtocol):
    """uvicorn's WebSocket protocol; aborts a connection that exceeds its byte budget.

    Attributes:
        slot: The connection's slot among those of the process.
    """

    slot: ConnectionSlot | None = None

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        self._budget = TokenBucket(RATE_BYTES_PER_S, BURST_BYTES, self.loop.time())
        self.default_headers = [*self.default_headers, *ENCODED_SECURITY_HEADERS]
        self._reject = self.conn.reject
        self.conn.reject = self._reject_safely  # type: ignore[method-assign]

    def _reject_safely(self, status: HTTPStatus | int, text: str) -> Response:
        """Refuse a handshake, with the headers of every other answer."""
        answer = self._reject(status, text)
        answer.headers.update(SECURITY_HEADERS)
        return answer

    def connection_lost(self, exc: Exception | None) -> None:
        """Free the slot."""
        if self.slot is not None:
            self.slot.release()
        super().connection_lost(exc)

    def data_received(self, data: bytes) -> None:
        """Pass on what the budget allows; abort without a closing handshake otherwise."""
        if self._budget.take(len(data), self.loop.time()):
            super().data_received(data)
        elif not self.transport.is_closing():
            _LOG.warning(
                "A page at %s sent more than %d bytes/s and was disconnected.",
                self.client,
                RATE_BYTES_PER_S,
            )
            self.transport.abort()
