"""Runs a server process, alone on its port or with others that share it."""

from __future__ import annotations

import asyncio
import gc
import logging.config
import os
import socket
import sys
from functools import partial
from typing import Any

import uvicorn
from fastapi import FastAPI

from server.app import create_app
from server.heap import keep_heap_small
from server.open_files import allow_open_files
from server.play.wire.byte_budget import BudgetedWebSocketProtocol
from server.play.wire.protocol import MAX_MESSAGE_BYTES
from server.services import Services
from server.web.connections import Connections
from server.web.exposure import check_exposure, is_proxy, may_connect
from server.web.http_protocol import MAX_HEAD_BYTES, HttpProtocol, ServerConfig
from server.web.security import MaskToken
from tril.errors import Unavailable
from tril.logs import PlainFormatter
from tril.settings import Settings
from tril.store.database import create_database
from tril.store.schema import check_schema
from tril.tls import tls_context

GRACEFUL_SHUTDOWN_S = 5

TLS_HANDSHAKE_S = 10.0
"""Until it is over a connection has no place yet."""

UNACKNOWLEDGED_MS = 30_000
"""How long what was sent may stay unacknowledged. Without this, connections to machines that are
asleep or unplugged would keep their places for a quarter of an hour."""

BACKLOG = 512

SWITCH_INTERVAL_S = 0.0005
"""How long another thread may keep the game loop from running; Python's default of 5 ms is a third
of a frame, and a tick waits several times."""

LOGGING: dict[str, Any] = {
    "version": 1,
    "disable_existing_loggers": False,
    "filters": {"mask_token": {"()": MaskToken}},
    "formatters": {
        "plain": {
            "()": PlainFormatter,
            "format": "%(asctime)s %(levelname)s %(name)s: %(message)s",
        }
    },
    "handlers": {
        "console": {
            "class": "logging.StreamHandler",
            "formatter": "plain",
            "filters": ["mask_token"],
            "stream": "ext://sys.stderr",
        }
    },
    "root": {"level": "INFO", "handlers": ["console"]},
    # A line for every request would scroll the printed address out of sight.
    "loggers": {"uvicorn.access": {"level": "WARNING"}},
}


class Server(uvicorn.Server):
    """uvicorn's server, which on shutdown also ends the event streams that it would wait for."""

    config: ServerConfig

    async def startup(self, sockets: list[socket.socket] | None = None) -> None:
        """Start, then exclude all present objects from garbage collections.

        A collection of these 160,000 objects takes 80 ms: five frames.
        """
        await super().startup([])
        if self.started:
            await self._listen(sockets or [])
            gc.collect()
            gc.freeze()

    async def _listen(self, sockets: list[socket.socket]) -> None:
        """Serve connections to sockets, as uvicorn does, but bound the time of TLS handshakes."""
        protocol = partial(
            HttpProtocol, self.config, self.server_state, app_state=self.lifespan.state
        )
        for listening in sockets:
            accepting = await asyncio.get_running_loop().create_server(
                protocol,
                sock=listening,
                backlog=BACKLOG,
                ssl=self.config.ssl,
                ssl_handshake_timeout=TLS_HANDSHAKE_S if self.config.ssl else None,
            )
            self.servers.append(accepting)

    async def shutdown(self, sockets: list[socket.socket] | None = None) -> None:
        """End the event streams, then stop."""
        app = self.config.app
        if isinstance(app, FastAPI) and hasattr(app.state, "services"):
            services: Services = app.state.services
            services.changes.close()
        await super().shutdown(sockets)
        # The emulator's library reports consoles that outlive the process.
        gc.unfreeze()


def run_server(settings: Settings, shares_port: bool = False) -> None:
    """Serve until a signal arrives.

    Args:
        settings: Settings of the server.
        shares_port: Whether other server processes may listen on the same port.

    Raises:
        Unavailable: The address is open to others without encryption, the port is taken, or the
            database is of another version; says what to do.
    """
    keep_heap_small()
    logging.config.dictConfig(LOGGING)
    sys.setswitchinterval(SWITCH_INTERVAL_S)
    check_exposure(settings)
    allow_open_files(settings)
    database = create_database(settings.application_url)
    try:
        check_schema(database)
    finally:
        database.close()
    listening = bind(settings, shares_port)
    with listening:
        Server(server_config(create_app(settings), settings)).run(sockets=[listening])


def server_config(app: FastAPI, settings: Settings) -> ServerConfig:
    """Return the configuration of uvicorn."""
    context = tls_context(settings)
    return ServerConfig(
        app,
        Connections(
            settings.max_connections,
            settings.max_connections_per_address,
            is_proxy(settings),
            may_connect(settings),
        ),
        host=settings.host,
        port=settings.port,
        http=HttpProtocol,
        h11_max_incomplete_event_size=MAX_HEAD_BYTES,
        log_config=None,
        server_header=False,
        ssl_context_factory=(lambda *_: context) if context else None,
        proxy_headers=False,  # TrustedProxies reads them
        ws=BudgetedWebSocketProtocol,
        # Compression by uvicorn takes seven times as long as our codec (docs/benchmarks.md).
        ws_per_message_deflate=False,
        ws_max_size=MAX_MESSAGE_BYTES * 4,
        ws_ping_interval=10.0,
        ws_ping_timeout=20.0,
        timeout_graceful_shutdown=GRACEFUL_SHUTDOWN_S,
    )


def bind(settings: Settings, shares_port: bool = False) -> socket.socket:
    """Bind the port and listen.

    Args:
        settings: The host and the port.
        shares_port: Whether other processes of this user may listen on it too, if they share it as
            well. The kernel distributes new connections among those that are alive.

    Raises:
        Unavailable: The port is taken, or the address is not this machine's.
    """
    listening = take_port(settings, shares_port)
    try:
        # Connections wait here until the application has started.
        listening.listen(BACKLOG)
    except OSError as error:
        listening.close()
        raise _port_unusable(settings, error) from error
    listening.set_inheritable(True)
    return listening


def take_port(settings: Settings, shares_port: bool = False) -> socket.socket:
    """Bind the port without listening, so that it gets no connections.

    The supervisor of several server processes checks in this way that they will get the port.

    Raises:
        Unavailable: The port is taken, or the address is not this machine's.
    """
    family = socket.AF_INET6 if ":" in settings.host else socket.AF_INET
    listener = socket.socket(family, socket.SOCK_STREAM)
    if os.name == "posix":
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        if hasattr(socket, "TCP_USER_TIMEOUT"):  # connections inherit it
            listener.setsockopt(socket.IPPROTO_TCP, socket.TCP_USER_TIMEOUT, UNACKNOWLEDGED_MS)
        if shares_port:
            listener.setsockopt(socket.SOL_SOCKET, _reuse_port(), 1)
        listener.bind((settings.host, settings.port))
    except OSError as error:
        listener.close()
        raise _port_unusable(settings, error) from error
    return listener


def _reuse_port() -> int:
    if not hasattr(socket, "SO_REUSEPORT"):
        raise Unavailable("Several server processes on one port are not possible on this system.")
    return socket.SO_REUSEPORT


def _port_unusable(settings: Settings, error: OSError) -> Unavailable:
    return Unavailable(
        f"Port {settings.port} on {settings.host} can't be used: {error.strerror}. Another "
        "Tril may be running; stop it, or choose another port with TRIL_PORT."
    )
