"""Messages between a vector and its processes, with few system calls and closure detection."""

import socket
import struct
from typing import Self

_HEADER = struct.Struct("<cI")
_CHUNK_BYTES = 1 << 16


class ChannelClosed(ConnectionError):
    """The other end was closed or its process has ended."""


class Channel:
    """One end of a stream of messages, each a kind of one byte and a value."""

    def __init__(self, end: socket.socket) -> None:
        """Take ownership of an end of a socket pair."""
        self._socket = end

    @classmethod
    def pair(cls) -> tuple[Self, socket.socket]:
        """Return a channel and the socket of its other end, for another process."""
        socket_here, socket_there = socket.socketpair()
        return cls(socket_here), socket_there

    def set_timeout(self, timeout_s: int) -> None:
        """Make `receive` return None after so long without a message."""
        timeval = struct.pack("@ll", timeout_s, 0)
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVTIMEO, timeval)

    def send(self, kind: bytes, value: bytes = b"") -> None:
        """Send a message.

        Raises:
            ChannelClosed: the other end is closed.
        """
        try:
            self._socket.sendall(_HEADER.pack(kind, len(value)) + value)
        except (BrokenPipeError, ConnectionResetError) as error:
            raise ChannelClosed("The other end of the channel is closed.") from error

    def receive(self) -> tuple[bytes, bytes] | None:
        """Wait for a message and return its kind and value; None after a timeout.

        Raises:
            ChannelClosed: the other end is closed.
        """
        try:
            # A single call for short messages: the other end waits for the reply.
            data = self._receive(_CHUNK_BYTES)
        except BlockingIOError:
            return None
        while len(data) < _HEADER.size:
            data += self._receive(_CHUNK_BYTES)
        kind, size = _HEADER.unpack_from(data)
        parts = [data[_HEADER.size :]]
        missing = size - len(parts[0])
        while missing > 0:
            parts.append(self._receive(min(missing, _CHUNK_BYTES)))
            missing -= len(parts[-1])
        return kind, b"".join(parts)

    def _receive(self, size: int) -> bytes:
        try:
            data = self._socket.recv(size)
        except ConnectionResetError as error:
            raise ChannelClosed("The other end of the channel is closed.") from error
        if not data:
            raise ChannelClosed("The other end of the channel is closed.")
        return data

    def close(self) -> None:
        """Close this end; the other one notices."""
        self._socket.close()
