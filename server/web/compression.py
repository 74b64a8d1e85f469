"""Compression of what the API and the pages answer.

Neither games nor event streams are compressed: a frame is encoded already, and an event must not
wait in a buffer. No answer holds a secret beside what a request chose, so that its size gives none
away: the key and the cookie never appear in a body.
"""

from __future__ import annotations

import asyncio
import gzip

from starlette.datastructures import Headers, MutableHeaders
from starlette.types import ASGIApp, Message, Receive, Scope, Send

LEVEL = 5
MAX_CODINGS_CHARACTERS = 256
"""As much of Accept-Encoding is looked at; browsers send 30."""

MIN_BYTES = 1024
"""Below this the headers weigh more than what is saved."""

_COMPRESSIBLE = frozenset(
    {
        "application/json",
        "application/manifest+json",
        "application/x-ndjson",
        "image/svg+xml",
        "text/css",
        "text/html",
        "text/javascript",
        "text/plain",
    }
)


def accepts(headers: Headers, coding: str) -> bool:
    """Whether the sender of a request takes a response with a content coding, such as gzip."""
    codings = headers.get("accept-encoding", "")[:MAX_CODINGS_CHARACTERS].lower()
    return coding in codings.replace(" ", "").split(",")


def is_compressible(media_type: str) -> bool:
    """Whether a media type is text that compression makes smaller."""
    return media_type.partition(";")[0].strip() in _COMPRESSIBLE


async def compressed(body: bytes) -> bytes:
    """Compress in a thread, since the event loop has games to serve."""
    return await asyncio.to_thread(gzip.compress, body, LEVEL, mtime=0)


class Compression:
    """Compresses answers that are text and sent as a whole."""

    def __init__(self, app: ASGIApp) -> None:
        self._app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass a request on and compress its answer."""
        if scope["type"] != "http" or not accepts(Headers(scope=scope), "gzip"):
            await self._app(scope, receive, send)
            return
        start: Message | None = None

        async def send_compressed(message: Message) -> None:
            nonlocal start
            if message["type"] == "http.response.start" and _may_compress(message):
                start = message
                return
            if start is not None:
                body = message.get("body", b"")
                if not message.get("more_body", False) and len(body) >= MIN_BYTES:
                    message = {**message, "body": await compressed(body)}
                    _announce(start, len(message["body"]))
                started, start = start, None
                await send(started)
            await send(message)

        await self._app(scope, receive, send_compressed)


def _may_compress(start: Message) -> bool:
    headers = Headers(raw=start["headers"])
    return "content-encoding" not in headers and is_compressible(headers.get("content-type", ""))


def _announce(start: Message, length: int) -> None:
    headers = MutableHeaders(raw=start["headers"])
    headers["Content-Encoding"] = "gzip"
    headers["Content-Length"] = str(length)
    headers.add_vary_header("Accept-Encoding")
    start["headers"] = headers.raw
