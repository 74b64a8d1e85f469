"""Who may reach the server, and how: TLS, proxies, addresses that are open to others."""

from __future__ import annotations

from collections.abc import Callable

from starlette.datastructures import Headers
from starlette.types import ASGIApp, Receive, Scope, Send
from uvicorn.middleware.proxy_headers import ProxyHeadersMiddleware

from tril.addresses import parse_address
from tril.errors import Unavailable
from tril.settings import Settings
from tril.tls import tls_context

_FORWARDED_HOST = "x-forwarded-host"


def check_exposure(settings: Settings) -> None:
    """Check that what others could read on the way is encrypted, and that TLS can be served.

    Raises:
        Unavailable: The address is open to others and nothing encrypts, or the certificate can't be
            used; says what to do.
    """
    tls_context(settings)
    if settings.is_local or settings.uses_tls or settings.proxies or settings.plain_http:
        return
    raise Unavailable(
        f"{settings.host} is open to other machines, and without encryption whoever is on the way "
        "can read the key and play with it. Set TRIL_TLS_CERTIFICATE and TRIL_TLS_KEY, or put a "
        "proxy in front and name its address in TRIL_TRUSTED_PROXIES (docs/operating.md). Where "
        "nobody else can listen, TRIL_PLAIN_HTTP=1 allows it."
    )


def is_proxy(settings: Settings) -> Callable[[str], bool]:
    """Return a function that tells whether an address is a trusted proxy's."""

    def holds(address: str) -> bool:
        parsed = parse_address(address)
        return parsed is not None and any(parsed in network for network in settings.proxies)

    return holds


def may_connect(settings: Settings) -> Callable[[str], bool]:
    """Return a function that tells whether an address may connect.

    Where a proxy encrypts, and an address is open to others, nobody may go past the proxy.
    """
    if settings.is_local or settings.uses_tls or settings.plain_http:
        return lambda _address: True
    is_trusted = is_proxy(settings)

    def holds(address: str) -> bool:
        parsed = parse_address(address)
        return parsed is not None and (parsed.is_loopback or is_trusted(address))

    return holds


class TrustedProxies:
    """Takes the client's address, scheme and host from what trusted proxies forward.

    Forwarded headers of others are ignored.

    Args:
        app: The application behind.
        settings: Names the proxies.
    """

    def __init__(self, app: ASGIApp, settings: Settings) -> None:
        self._is_proxy = is_proxy(settings)
        self._forwarded = ProxyHeadersMiddleware(app, list(map(str, settings.proxies)))  # type: ignore[arg-type]
        self._app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass a request on as its client sent it."""
        client = scope.get("client")
        if (
            scope["type"] not in {"http", "websocket"}
            or not client
            or not self._is_proxy(client[0])
        ):
            await self._app(scope, receive, send)
            return
        # An IPv4 address may be written as an IPv6 one, which no IPv4 network contains.
        scope = {**scope, "client": (str(parse_address(client[0])), client[1])}
        hosts = Headers(scope=scope).getlist(_FORWARDED_HOST)
        if len(hosts) == 1 and "," not in hosts[0]:
            headers = [(name, value) for name, value in scope["headers"] if name != b"host"]
            scope["headers"] = [(b"host", hosts[0].strip().encode("latin-1")), *headers]
        await self._forwarded(scope, receive, send)  # type: ignore[arg-type]
