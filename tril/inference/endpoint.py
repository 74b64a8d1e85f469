"""Where the inference process answers: on a local socket, or on an address that a key guards."""

from __future__ import annotations

import asyncio
import os
import socket
import ssl
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path

from tril.addresses import TcpAddress
from tril.errors import Invalid, Unavailable
from tril.inference.messages import receive_exactly
from tril.inference.proof import (
    GREETING_BYTES,
    PROOF_BYTES,
    NotProven,
    Response,
    shown_certificate_hash,
)
from tril.settings import Settings

LONGEST_ADDRESS = 100
"""Bytes of a path that fit into the address of a local socket, with some margin."""

CONNECT_TIMEOUT_S = 5.0
"""For a connection over TCP, and for the proof of the key on it."""

MIN_KEY_CHARACTERS = 32
"""Whoever reads a proof on its way can try keys against it."""

_SILENT_FOR_S, _PROBE_EVERY_S, _PROBES = 10, 5, 3

Streams = tuple[asyncio.StreamReader, asyncio.StreamWriter]


@dataclass(frozen=True)
class LocalEndpoint:
    """A socket in the data folder, which the file's mode guards.

    Attributes:
        path: The socket.
    """

    path: Path

    def __str__(self) -> str:
        return str(self.path)

    def connect(self, timeout_s: float) -> socket.socket:
        """Return a connection, whose operations may take so long; raises OSError."""
        connection = socket.socket(socket.AF_UNIX)
        try:
            connection.settimeout(timeout_s)
            with address_of(self.path) as address:
                connection.connect(address)
        except BaseException:
            connection.close()
            raise
        return connection

    async def open(self) -> Streams:
        """Return the streams of a connection; raises OSError."""
        with address_of(self.path) as address:
            return await asyncio.open_unix_connection(address)

    def unavailable(self, problem: OSError) -> Unavailable:
        """Return the error that tells a person of a process that can't be reached."""
        reason = "did not answer in time" if isinstance(problem, TimeoutError) else "is not running"
        return Unavailable(
            f"The inference process {reason}, so no network can be asked. `tril up` starts it, "
            "again if need be; try again in a moment."
        )


@dataclass(frozen=True)
class TcpEndpoint:
    """An address, on this machine or another one, where both ends prove that they have a key.

    Attributes:
        address: The address.
        key: The key.
    """

    address: TcpAddress
    key: bytes = field(repr=False)

    def __str__(self) -> str:
        return str(self.address)

    def connect(self, timeout_s: float) -> socket.socket:
        """Return a connection on which both ends have proven that they have the key.

        Args:
            timeout_s: Timeout of later operations on the connection.

        Raises:
            OSError: The process can't be reached.
            Unavailable: What answers has another key, or is something else.
        """
        destination = self.address.destination
        connection = socket.create_connection(destination, CONNECT_TIMEOUT_S)
        try:
            tune(connection)
            certificate = b""
            if self.address.is_encrypted:
                connection = _client_context().wrap_socket(connection)
                certificate = shown_certificate_hash(connection)
            response = self._respond(
                receive_exactly(connection, GREETING_BYTES, CONNECT_TIMEOUT_S), certificate
            )
            connection.sendall(response.message)
            self._check(response, receive_exactly(connection, PROOF_BYTES, CONNECT_TIMEOUT_S))
            connection.settimeout(timeout_s)
        except BaseException:
            connection.close()
            raise
        return connection

    async def open(self) -> Streams:
        """Return the streams of a connection; raises as ``connect``."""
        async with asyncio.timeout(CONNECT_TIMEOUT_S):
            host, port = self.address.destination
            tls = _client_context() if self.address.is_encrypted else None
            reader, writer = await asyncio.open_connection(host, port, ssl=tls)
            try:
                tune(writer.get_extra_info("socket"))
                layer = writer.get_extra_info("ssl_object")
                certificate = b"" if layer is None else shown_certificate_hash(layer)
                response = self._respond(await reader.readexactly(GREETING_BYTES), certificate)
                writer.write(response.message)
                self._check(response, await reader.readexactly(PROOF_BYTES))
            except BaseException:
                disconnect(writer)
                raise
        return reader, writer

    def unavailable(self, problem: OSError) -> Unavailable:
        """Return the error that tells a person of a process that can't be reached."""
        reason = (
            "it did not answer in time"
            if isinstance(problem, TimeoutError)
            else problem.strerror or str(problem)
        )
        return Unavailable(
            f"The inference process can't be reached at {self} ({reason}), so no network can be"
            " asked. Start `tril inference` there; try again in a moment."
        )

    def _respond(self, greeting: bytes | bytearray, certificate: bytes) -> Response:
        try:
            return Response(self.key, greeting, certificate)
        except NotProven as problem:
            raise self._other(problem) from problem

    def _check(self, response: Response, answer: bytes | bytearray) -> None:
        try:
            response.check(answer)
        except NotProven as problem:
            raise self._other(problem) from problem

    def _other(self, problem: NotProven) -> Unavailable:
        return Unavailable(
            f"What answers at {self} {problem}. TRIL_INFERENCE_ADDRESS has to lead to the process"
            " that `tril inference` runs, and TRIL_INFERENCE_KEY has to be the same there and here."
        )


Endpoint = LocalEndpoint | TcpEndpoint


def endpoint_of(settings: Settings) -> Endpoint:
    """Return the address of the inference process.

    Raises:
        Invalid: An address has no key or too short a one, or can be read by others on the way;
            says what to do.
    """
    address = settings.inference_tcp_address
    if address is None:
        return LocalEndpoint(settings.inference_socket)
    key = settings.secret("inference_key")
    if len(key) < MIN_KEY_CHARACTERS:
        lacks = "is too short" if key else "is missing"
        raise Invalid(
            f"The inference process answers at {address} only those who have a key, which {lacks}."
            " Make one with `openssl rand -hex 32 > inference-key`, and name that file in"
            " TRIL_INFERENCE_KEY_FILE, here and where the inference process or the server is."
        )
    if not (address.is_local or address.is_encrypted or settings.plain_http):
        raise Invalid(
            f"{address} leads to other machines, and without encryption whoever is on the way can"
            " read and change what networks are asked and answer. Write tls:// for tcp://, here and"
            " where the inference process or the server is. Where nobody else can listen,"
            " TRIL_PLAIN_HTTP=1 allows it."
        )
    return TcpEndpoint(address, key.encode())


def disconnect(writer: asyncio.StreamWriter) -> None:
    """Close a connection from ``open`` at once.

    ``writer.close()`` would leave a TLS connection open until the other end answers the goodbye, or
    for 30 seconds, and for good if the event loop ends before.
    """
    writer.transport.abort()


def tune(connection: socket.socket) -> None:
    """Send small messages at once, and notice within half a minute that the other end is gone."""
    connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    connection.setsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE, 1)
    for name, value in (
        ("TCP_KEEPIDLE", _SILENT_FOR_S),
        ("TCP_KEEPINTVL", _PROBE_EVERY_S),
        ("TCP_KEEPCNT", _PROBES),
    ):
        if hasattr(socket, name):  # not on every system
            connection.setsockopt(socket.IPPROTO_TCP, getattr(socket, name), value)


@cache
def _client_context() -> ssl.SSLContext:
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
    context.minimum_version = ssl.TLSVersion.TLSv1_3
    # The proof of the key covers the certificate, so no authority has to know it.
    context.check_hostname = False
    context.verify_mode = ssl.CERT_NONE
    return context


@contextmanager
def address_of(path: Path) -> Iterator[str]:
    """Give an address of a local socket, valid in the block, even if the path is too long for one.

    Raises:
        Unavailable: The path is too long on a system without /proc/self/fd.
    """
    if len(os.fsencode(path)) <= LONGEST_ADDRESS:
        yield str(path)
        return
    if not Path("/proc/self/fd").is_dir():
        raise Unavailable(
            f"The data folder's path is too long for a local socket ({path}). Choose a shorter one "
            "with TRIL_DATA."
        )
    folder = os.open(path.parent, os.O_RDONLY | os.O_DIRECTORY)
    try:
        yield f"/proc/self/fd/{folder}/{path.name}"
    finally:
        os.close(folder)
