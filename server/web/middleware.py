"""ASGI middleware for HTTP and WebSockets: security headers, origin, authentication, body size.

Neither uvicorn nor Starlette checks the Origin of a WebSocket, and browsers send the cookies of
127.0.0.1 to each of its ports: without these checks a page of another local server could connect.
"""

from __future__ import annotations

import asyncio
import re
from urllib.parse import urlsplit

from fastapi import HTTPException
from starlette.datastructures import Headers, MutableHeaders
from starlette.requests import HTTPConnection
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from server.dependencies import services_of
from server.web.problems import problem
from server.web.security_headers import SECURITY_HEADERS
from tril.errors import Unavailable
from tril.store.access.credentials import Identity

RawHeaders = list[tuple[bytes, bytes]]

PUBLIC_PATHS = frozenset({"/api/health"})
CLOSE_UNAUTHORISED = 4401
CLOSE_TRY_AGAIN_LATER = 1013

MAX_BODY_BYTES = 64 * 1024
MAX_RANKING_BYTES = 256 * 1024
"""Twenty thousand recordings, each in a tier of its own."""
MAX_PARTICIPANTS_BODY_BYTES = 16 * 1024
"""What participants send are names, frames and choices."""
MAX_STRANGERS_BODY_BYTES = 8 * 1024
"""A name and what a link contains."""
MAX_UPLOAD_BYTES = 16 * 1024 * 1024
BODY_TIMEOUT_S = 20.0
"""How long a body may take to arrive; an upload has more time, in its turn."""
_UPLOAD_END = "/recordings/import"
_RANKING_ENDS = ("/ranking", "/ranking/understanding")

MAX_HOST_CHARACTERS = 300
"""A host name has at most 255, and there is a scheme and a port beside it."""

_DEFAULT_PORTS = {"http": 80, "https": 443, "ws": 80, "wss": 443}


class SameOrigin:
    """Refuses requests to an unknown host name and requests from other sites' pages (403).

    Args:
        app: The application behind.
        host_names: Names of this server, lower case and without port.
    """

    def __init__(self, app: ASGIApp, host_names: frozenset[str]) -> None:
        self._app = app
        self._host_names = host_names

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass a request on or refuse it."""
        if scope["type"] in {"http", "websocket"} and (refusal := self._refusal(scope)):
            await _refuse(scope, receive, send, 403, refusal)
        else:
            await self._app(scope, receive, send)

    def _refusal(self, scope: Scope) -> str | None:
        headers = Headers(scope=scope)
        host = _host_and_port(f"http://{headers.get('host', '')}")
        if len(headers.getlist("host")) != 1 or host is None or host[0] not in self._host_names:
            return (
                "This server does not answer under that host name. Open it under the printed "
                "address, or add the name to TRIL_ALLOWED_HOSTS."
            )
        origin = headers.get("origin")
        if origin is not None:
            scheme = origin.partition("://")[0].lower()
            own_host = _host_and_port(f"{scheme}://{headers['host']}")
            # A page that came without encryption may be anybody's.
            allowed = {"https"} if scope["scheme"] in {"https", "wss"} else {"http", "https"}
            if scheme not in allowed or _host_and_port(origin) != own_host:
                return "Requests from other sites' pages are refused."
        elif _is_api(scope) and headers.get("sec-fetch-site") in {"cross-site", "same-site"}:
            return "Requests from other sites' pages are refused."
        return None


class Authentication:
    """Refuses requests to the API without a valid sign-in (401; 4401 closes a WebSocket).

    Others are passed on with their identity. An open WebSocket is closed when they are signed out.
    """

    def __init__(self, app: ASGIApp) -> None:
        self._app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass a request on or refuse it."""
        if scope["type"] not in {"http", "websocket"}:
            await self._app(scope, receive, send)
            return
        connection = HTTPConnection(scope)
        name = services_of(connection).access.cookie_name
        scope["headers"] = _with_own_cookie(scope["headers"], name.encode())
        if scope["path"] in PUBLIC_PATHS:
            # They have no parameters, and FastAPI parses whatever is there.
            scope["query_string"] = b""
        if not _is_api(scope) or scope["path"] in PUBLIC_PATHS:
            await self._app(scope, receive, send)
            return
        connection = HTTPConnection(scope)
        try:
            identity = await services_of(connection).access.identify(connection)
        except Unavailable as error:
            reason = "Your sign-in can't be checked right now. Try again in a moment."
            await _refuse_temporarily(scope, receive, send, str(error), reason)
            return
        if identity is None:
            await _refuse_unauthenticated(scope, receive, send)
            return
        scope["identity"] = identity
        if scope["type"] == "http":
            await self._app(scope, receive, send)
        else:
            await self._forward_until_signed_out(scope, receive, send)

    async def _forward_until_signed_out(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Forward a WebSocket; close it if its browser is signed out or its rights change."""
        closing: asyncio.Task[None] | None = None

        async def close(may_return: bool) -> None:
            code, why = CLOSE_UNAUTHORISED, "You have been signed out."
            if may_return:
                code, why = CLOSE_TRY_AGAIN_LATER, "What you may do has changed."
            await send({"type": "websocket.close", "code": code, "reason": why})

        def end(may_return: bool) -> None:
            nonlocal closing
            closing = closing or asyncio.create_task(close(may_return))

        async def send_unless_closed(message: Message) -> None:
            if closing is None:
                await send(message)

        access = services_of(HTTPConnection(scope)).access
        try:
            access.refuse_too_many_open(scope["identity"])
        except Unavailable as error:
            await _refuse_temporarily(scope, receive, send, str(error), str(error))
            return
        with access.watch_rights(scope["identity"], end):
            await self._app(scope, receive, send_unless_closed)


async def _refuse_temporarily(
    scope: Scope, receive: Receive, send: Send, why: str, reason: str
) -> None:
    if scope["type"] == "websocket":
        # Once it is accepted, so that the page hears that it may try again.
        await send({"type": "websocket.accept"})
        await send({"type": "websocket.close", "code": CLOSE_TRY_AGAIN_LATER, "reason": reason})
    else:
        await problem(503, why)(scope, receive, send)


async def _refuse_unauthenticated(scope: Scope, receive: Receive, send: Send) -> None:
    why = "You are not signed in. Open the address that Tril printed when it started."
    if scope["type"] == "websocket":
        await send({"type": "websocket.accept"})
        await send({"type": "websocket.close", "code": CLOSE_UNAUTHORISED, "reason": why})
    else:
        await _refuse(scope, receive, send, 401, why)


class BodyLimit:
    """Refuses bodies that are too large (413), and those that never come (408).

    JSON and forms are parsed and validated in the event loop, so that how much they may have hangs
    on who sends them. All bodies declare their length: see ``HttpProtocol``.
    """

    def __init__(self, app: ASGIApp) -> None:
        self._app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass a request on and time its body."""
        if scope["type"] != "http":
            await self._app(scope, receive, send)
            return
        is_upload = scope["path"].endswith(_UPLOAD_END)
        limit = _limit_of(scope.get("identity"), scope["path"])
        declared = Headers(scope=scope).get("content-length", "0")
        # Python reads no number of thousands of digits.
        if not declared.isdecimal() or len(declared) > 20 or int(declared) > limit:
            why = f"The body is too large: at most {limit // 1024} KiB are accepted."
            await _refuse(scope, receive, send, 413, why)
            return
        is_awaited = not is_upload
        until = asyncio.get_running_loop().time() + BODY_TIMEOUT_S

        async def receive_before_deadline() -> Message:
            nonlocal is_awaited
            try:
                async with asyncio.timeout_at(until if is_awaited else None):
                    message = await receive()
            except TimeoutError:
                raise HTTPException(408, "The request took too long to arrive.") from None
            is_awaited = is_awaited and message.get("more_body", False)
            return message

        await self._app(scope, receive_before_deadline, send)


class SecurityHeaders:
    """Adds security headers to every answer, and no-store to those of the API."""

    def __init__(self, app: ASGIApp) -> None:
        self._app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass a request on and complete the headers of its answer."""

        async def send_completed(message: Message) -> None:
            if message["type"] == "http.response.start":
                headers = MutableHeaders(scope=message)
                for name, value in SECURITY_HEADERS.items():
                    headers.setdefault(name, value)
                if _is_api(scope):
                    headers.setdefault("Cache-Control", "no-store")
            await send(message)

        await self._app(scope, receive, send_completed)


def _limit_of(identity: Identity | None, path: str) -> int:
    if identity is None:
        return MAX_STRANGERS_BODY_BYTES
    if identity.is_participant:
        return MAX_PARTICIPANTS_BODY_BYTES
    if path.endswith(_UPLOAD_END):
        return MAX_UPLOAD_BYTES
    return MAX_RANKING_BYTES if path.endswith(_RANKING_ENDS) else MAX_BODY_BYTES


def _with_own_cookie(headers: RawHeaders, name: bytes) -> RawHeaders:
    """Return headers in which of all cookies only this server's is left.

    Starlette and FastAPI parse all cookies of every request by Python's ``http.cookies``, which
    before 3.11.10 takes minutes for 60 kB of backslashes between quotes (CVE-2024-7592).
    """
    cookie = re.compile(rb"(?:^|;)[ \t]*%b=\"?([A-Za-z0-9._-]{1,128})\"?[ \t]*(?=;|$)" % name)
    other_headers = [(key, value) for key, value in headers if key != b"cookie"]
    values = [
        value for key, header in headers if key == b"cookie" for value in cookie.findall(header)
    ]
    return [*other_headers, (b"cookie", name + b"=" + values[-1])] if values else other_headers


def _is_api(scope: Scope) -> bool:
    path: str = scope["path"]
    return path == "/api" or path.startswith("/api/")


def _host_and_port(url: str) -> tuple[str, int] | None:
    if len(url) > MAX_HOST_CHARACTERS:
        return None
    try:
        parts = urlsplit(url)
        port = parts.port or _DEFAULT_PORTS.get(parts.scheme)
    except ValueError:
        return None
    if parts.username or parts.password or not parts.hostname or port is None:
        return None
    return parts.hostname, port


async def _refuse(scope: Scope, receive: Receive, send: Send, status: int, why: str) -> None:
    if scope["type"] == "websocket":
        # Closing before accepting refuses the handshake.
        await send({"type": "websocket.close", "code": 1008, "reason": why})
        return
    await problem(status, why)(scope, receive, send)
