"""Middleware at the door, as pure ASGI: it sees HTTP and WebSockets alike, before any route.

Neither uvicorn nor Starlette checks the Origin of a WebSocket, and cookies of 127.0.0.1 go to
every port of it: a page of another local server is kept out here.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any
from urllib.parse import urlsplit

from fastapi import HTTPException
from starlette.datastructures import Headers, MutableHeaders
from starlette.requests import HTTPConnection
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from server.dependencies import services_of
from server.web.problems import problem

OPEN_PATHS = frozenset({"/api/health"})
CLOSE_UNAUTHORISED = 4401

MAX_BODY_BYTES = 1024 * 1024
MAX_UPLOAD_BYTES = 16 * 1024 * 1024
_UPLOAD_END = "/recordings/import"

_DEFAULT_PORTS = {"http": 80, "https": 443, "ws": 80, "wss": 443}

SECURITY_HEADERS = {
    # Inline styles are what drag and drop and charts set on elements; scripts come from files.
    "Content-Security-Policy": (
        "default-src 'none'; script-src 'self'; style-src 'self' 'unsafe-inline'; "
        "img-src 'self' data: blob:; font-src 'self'; connect-src 'self'; worker-src 'self'; "
        "manifest-src 'self'; base-uri 'none'; form-action 'self'; frame-ancestors 'none'"
    ),
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
    "Referrer-Policy": "same-origin",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Permissions-Policy": "camera=(), geolocation=(), microphone=(), payment=(), usb=()",
}


class SameOrigin:
    """Refuses requests that name a host that isn't ours, or come from another site's page.

    Args:
        app: What comes behind.
        host_names: Lower-case names (without port) under which this server is reached.
    """

    def __init__(self, app: ASGIApp, host_names: frozenset[str]) -> None:
        self._app = app
        self._host_names = host_names

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass a request on or refuse it with 403; a WebSocket's handshake alike."""
        if scope["type"] in {"http", "websocket"} and (refusal := self._refusal(scope)):
            await _refuse(scope, receive, send, 403, refusal)
            return
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
            scheme = urlsplit(origin).scheme if "://" in origin else ""
            own = _host_and_port(f"{scheme}://{headers['host']}")
            if scheme not in {"http", "https"} or _host_and_port(origin) != own:
                return "Requests from other sites' pages are refused."
        elif _is_api(scope) and headers.get("sec-fetch-site") in {"cross-site", "same-site"}:
            return "Requests from other sites' pages are refused."
        return None


class SignedIn:
    """Refuses requests to the API without a good cookie: 401, or a WebSocket closed with 4401."""

    def __init__(self, app: ASGIApp) -> None:
        self._app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass a request on or refuse it."""
        if (
            scope["type"] in {"http", "websocket"}
            and _is_api(scope)
            and scope["path"] not in OPEN_PATHS
            and not has_cookie(HTTPConnection(scope))
        ):
            why = "You are not signed in. Open the address that Tril printed when it started."
            if scope["type"] == "websocket":
                await send({"type": "websocket.accept"})
                await send({"type": "websocket.close", "code": CLOSE_UNAUTHORISED, "reason": why})
            else:
                await _refuse(scope, receive, send, 401, why)
            return
        await self._app(scope, receive, send)


def has_cookie(connection: HTTPConnection) -> bool:
    """Whether a request carries a good cookie."""
    access = services_of(connection).access
    return access.is_cookie(connection.cookies.get(access.cookie_name, ""))


class BoundedBody:
    """Refuses bodies that are too large, also those that don't say how large they are."""

    def __init__(self, app: ASGIApp) -> None:
        self._app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass a request on, counting what its body brings."""
        if scope["type"] != "http":
            await self._app(scope, receive, send)
            return
        limit = MAX_UPLOAD_BYTES if scope["path"].endswith(_UPLOAD_END) else MAX_BODY_BYTES
        too_large = f"The body is too large: at most {limit // 1024} KiB are accepted."
        declared = Headers(scope=scope).get("content-length", "0")
        if not declared.isdecimal() or int(declared) > limit:
            await _refuse(scope, receive, send, 413, too_large)
            return
        received = 0

        async def counted() -> Message:
            nonlocal received
            message = await receive()
            received += len(message.get("body", b""))
            if received > limit:
                raise HTTPException(413, too_large)
            return message

        await self._app(scope, counted, send)


class SecurityHeaders:
    """Adds to every answer what browsers have to be told."""

    def __init__(self, app: ASGIApp) -> None:
        self._app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass a request on and complete its answer."""
        if scope["type"] != "http":
            await self._app(scope, receive, send)
            return

        async def completed(message: Message) -> None:
            if message["type"] == "http.response.start":
                headers = MutableHeaders(scope=message)
                for name, value in SECURITY_HEADERS.items():
                    headers.setdefault(name, value)
                if _is_api(scope):
                    headers.setdefault("Cache-Control", "no-store")
            await send(message)

        await self._app(scope, receive, completed)


def layers(host_names: frozenset[str]) -> list[tuple[Callable[..., Any], dict[str, Any]]]:
    """Return the middleware with its arguments, outermost first."""
    return [
        (SecurityHeaders, {}),
        (SameOrigin, {"host_names": host_names}),
        (SignedIn, {}),
        (BoundedBody, {}),
    ]


def _is_api(scope: Scope) -> bool:
    path: str = scope["path"]
    return path == "/api" or path.startswith("/api/")


def _host_and_port(url: str) -> tuple[str, int] | None:
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
        # Closed before it was accepted: the browser sees a refused handshake.
        await send({"type": "websocket.close", "code": 1008, "reason": why})
        return
    await problem(status, why)(scope, receive, send)
