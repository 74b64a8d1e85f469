"""The inference process: evaluates reward models and policies for the server."""

from __future__ import annotations

import contextlib
import errno
import fcntl
import logging
import os
import select
import signal
import socket
import socketserver
import ssl
import threading
from typing import Any

import torch
from sqlalchemy.exc import SQLAlchemyError

from trainer.progress import CallbackProgress
from trainer.runtime.answers import Answers, Models
from trainer.runtime.logs import set_up_logging
from trainer.runtime.priority import learning_threads
from tril.errors import Invalid, NotFound, TrilError, Unavailable
from tril.files.artifact_store import ArtifactStore
from tril.heartbeat import Heartbeat
from tril.inference import LocalEndpoint, TcpEndpoint, endpoint_of
from tril.inference.endpoint import CONNECT_TIMEOUT_S, address_of, tune
from tril.inference.messages import Disconnected, receive_exactly, receive_message, send_message
from tril.inference.proof import (
    REFUSAL,
    RESPONSE_BYTES,
    Challenge,
    NotProven,
    certificate_hash,
)
from tril.settings import Settings
from tril.store.database import create_database
from tril.store.schema import check_schema
from tril.tls import tls_context

log = logging.getLogger(__name__)

THREADS = 2
MESSAGE_TIMEOUT_S = 30.0
SOCKET_MODE = 0o600
MAX_CONNECTIONS = 256
"""Connections over TCP at the same time; each has a thread, before it has proven anything, too."""


def run_inference(settings: Settings) -> None:
    """Run the inference process until it is told to stop (SIGTERM or Ctrl-C).

    Raises:
        Invalid: The settings don't say who may ask it.
        Unavailable: Another process serves this data folder or has the address, the certificate
            can't be used, or the database is of another version.
    """
    set_up_logging()
    torch.set_num_threads(min(THREADS, learning_threads(0)))
    endpoint = endpoint_of(settings)
    database = create_database(settings.application_url)
    host = socket.gethostname()
    try:
        check_schema(database)
        models = Models(database, ArtifactStore(settings.artifact_root))
        server = new_server(settings, models)
        for number in (signal.SIGINT, signal.SIGTERM):
            # shutdown waits for the loop that this thread runs.
            signal.signal(number, lambda *_: threading.Thread(target=server.shutdown).start())
        with (
            server,
            Heartbeat(
                database,
                f"inference-{host[:40]}-{os.getpid()}",
                "inference",
                lambda: {"host": host},
            ),
        ):
            log.info("Inference answers on %s.", endpoint)
            server.serve_forever(poll_interval=0.2)
    finally:
        database.close()


def new_server(settings: Settings, models: Models) -> LocalServer | TcpServer:
    """Return a server that listens where settings say; raises as ``run_inference``."""
    endpoint = endpoint_of(settings)
    if isinstance(endpoint, LocalEndpoint):
        return LocalServer(endpoint, models)
    return TcpServer(endpoint, models, settings)


class LocalServer(socketserver.ThreadingUnixStreamServer):
    """Answers requests on a local socket that only its owner may use.

    Args:
        endpoint: The socket; one that a dead process left is replaced.
        models: The models.

    Raises:
        Unavailable: Another process answers on it.
    """

    daemon_threads = True

    def __init__(self, endpoint: LocalEndpoint, models: Models) -> None:
        self.models = models
        self._path = path = endpoint.path
        path.parent.mkdir(parents=True, exist_ok=True)
        self._lock_file = path.with_suffix(".lock").open("a")
        try:
            # Not flock: its lock would pass on to processes that inherit the descriptor.
            fcntl.lockf(self._lock_file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as problem:
            self._lock_file.close()
            if problem.errno not in {errno.EAGAIN, errno.EACCES}:
                raise
            raise Unavailable("Another inference process serves this data folder.") from problem
        path.unlink(missing_ok=True)
        earlier = os.umask(0o777 & ~SOCKET_MODE)
        try:
            with address_of(path) as address:
                super().__init__(address, _Handler)
        finally:
            os.umask(earlier)

    def server_close(self) -> None:
        """Close and remove the socket."""
        super().server_close()
        self._path.unlink(missing_ok=True)
        self._lock_file.close()

    def admit(self, request: socket.socket) -> socket.socket:
        """Return the connection on which a client's requests come: whoever got here may ask."""
        return request


class TcpServer(socketserver.ThreadingTCPServer):
    """Answers requests over TCP, of clients that prove that they have the key.

    Args:
        endpoint: Where it listens, and the key.
        models: The models.
        settings: Name the certificate, if the address is encrypted.

    Raises:
        Invalid: The address is encrypted and there is no certificate.
        Unavailable: The certificate can't be used, or the address is taken or another machine's.
    """

    daemon_threads = True
    allow_reuse_address = True
    request_queue_size = 64

    def __init__(self, endpoint: TcpEndpoint, models: Models, settings: Settings) -> None:
        self.models = models
        self._key = endpoint.key
        self._tls = _server_context(settings) if endpoint.address.is_encrypted else None
        self._certificate_hash = b""
        if self._tls is not None and settings.tls_certificate is not None:
            self._certificate_hash = certificate_hash(settings.tls_certificate)
        self._places = threading.BoundedSemaphore(MAX_CONNECTIONS)
        address = endpoint.address
        try:
            (family, *_, socket_address), *_ = socket.getaddrinfo(
                address.host, address.port, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE
            )
            self.address_family = family
            super().__init__(socket_address, _Handler)  # type: ignore[arg-type]
        except OSError as problem:
            raise Unavailable(
                f"The inference process can't listen at {address}: {problem.strerror}. If it runs"
                " on another machine, start Tril here with `tril up --no-inference`; else choose"
                " another address with TRIL_INFERENCE_ADDRESS."
            ) from problem

    def process_request(self, request: Any, client_address: Any) -> None:
        """Answer a connection in a thread of its own; one too many is closed."""
        if self._places.acquire(blocking=False):
            super().process_request(request, client_address)
        else:
            self.shutdown_request(request)

    def process_request_thread(self, request: Any, client_address: Any) -> None:
        """Answer a connection, and give its place back."""
        try:
            super().process_request_thread(request, client_address)
        finally:
            self._places.release()

    def admit(self, request: socket.socket) -> socket.socket:
        """Return the connection on which a client's requests come, once it has proven the key.

        Raises:
            NotProven: It has another key.
            OSError: It did not say anything in time, or not what it should.
        """
        request.settimeout(CONNECT_TIMEOUT_S)
        tune(request)
        if self._tls is not None:
            request = self._tls.wrap_socket(request, server_side=True)
        try:
            challenge = Challenge(self._key, self._certificate_hash)
            request.sendall(challenge.greeting)
            response = receive_exactly(request, RESPONSE_BYTES, CONNECT_TIMEOUT_S)
            try:
                request.sendall(challenge.answer(response))
            except NotProven:
                request.sendall(REFUSAL)
                raise
        except BaseException:
            request.close()
            raise
        return request


def _server_context(settings: Settings) -> ssl.SSLContext:
    context = tls_context(settings)
    if context is None:
        raise Invalid(
            "An address that begins with tls:// needs TRIL_TLS_CERTIFICATE and TRIL_TLS_KEY. Any"
            " certificate will do, one that the machine signs itself, too: docs/operating.md says"
            " how to make one."
        )
    context.minimum_version = ssl.TLSVersion.TLSv1_3
    # Tickets would reach a client that waits for its reply.
    context.num_tickets = 0
    return context


class _Handler(socketserver.BaseRequestHandler):
    """One connection: requests and their replies in turns."""

    server: LocalServer | TcpServer
    request: socket.socket

    def handle(self) -> None:
        try:
            connection = self.server.admit(self.request)
        except (OSError, NotProven) as problem:
            log.warning("A connection from %s was refused: %s", self.client_address, problem)
            return
        with connection:
            connection.settimeout(MESSAGE_TIMEOUT_S)
            answers = Answers(self.server.models)
            # The client may have disconnected.
            with contextlib.suppress(ConnectionError, TimeoutError, ssl.SSLError):
                while self._handle_request(connection, answers):
                    pass

    def _handle_request(self, connection: socket.socket, answers: Answers) -> bool:
        """Handle a request; return whether another may follow on this connection."""
        is_understood = False
        try:
            header, body = receive_message(connection)
            is_understood = True
            progress = CallbackProgress(lambda: _stop_if_disconnected(connection))
            facts, values = answers.to(header, body, progress)
            reply: dict[str, Any] = {"ok": True, **facts}
        except Disconnected:
            return False
        except (TrilError, SQLAlchemyError) as problem:
            reply, values = _error_reply(problem), b""
        except Exception as problem:
            log.exception("A request failed.")
            reply, values = _error_reply(problem), b""
        send_message(connection, reply, values)
        # After a message that was not understood, nobody knows where the next one begins.
        return is_understood


def _stop_if_disconnected(connection: socket.socket) -> None:
    # A client sends nothing after its request, so what can be read is the end of the stream.
    if select.select([connection], [], [], 0)[0]:
        raise Disconnected("The client gave up.")


def _error_reply(problem: Exception) -> dict[str, Any]:
    kinds = {Invalid: "invalid", NotFound: "not_found"}
    kind = next((name for cls, name in kinds.items() if isinstance(problem, cls)), "unavailable")
    detail = str(problem)
    if not isinstance(problem, TrilError):
        detail = f"The inference process failed ({type(problem).__name__}: {detail})."
    return {"ok": False, "kind": kind, "detail": detail}
