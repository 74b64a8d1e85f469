"""The messages of the inference process and its clients.

A message is a little-endian u32, the length of a JSON header, the header, and ``n_bytes`` raw bytes
as the header says. Nothing is pickled. A connection carries requests and their replies in turns;
one that is idle for half a minute is closed.

Requests, with observations uint8 (N, 4, 84, 84):

- ``{"op": "ping"}``
- ``{"op": "judge", "run_id"}`` gives R of each observation and its standard deviation, float32
  (2, N); the deviations are NaN if the reward model does not know them.
- ``{"op": "act", "run_id", "policies"}`` gives the probability of each action, float32 (N, 6), by
  the policy named for each observation. A connection keeps the policies it has used, so that a game
  is played by one policy even if a resumed run replaces its file.
- ``{"op": "scale", "run_id"}`` gives R at which the level is 0 and R at which it is 1, float32
  (2,).
- ``{"op": "attention", "run_id", "network", "method", "background"}`` gives the attention map of
  one observation, float32 (84, 84), and in the reply's header the ``action`` that a policy would
  choose, null of a reward model. ``background`` is the gray of the game's screen, 0 to 255. The
  work ends when the client disconnects.

A reply is ``{"ok": true}`` with the values or ``{"ok": false, "kind", "detail"}``.
"""

from __future__ import annotations

import json
import socket
import struct
import time
from typing import Any

import numpy as np

from tril.errors import Invalid, NotFound, Unavailable
from tril.play.observation import OBSERVATION_SHAPE

MAX_HEADER_BYTES = 16 * 1024
MAX_OBSERVATIONS = 1024
OBSERVATION_BYTES = int(np.prod(OBSERVATION_SHAPE))
MAX_BODY_BYTES = MAX_OBSERVATIONS * OBSERVATION_BYTES

_LENGTH = struct.Struct("<I")
LENGTH_BYTES = _LENGTH.size
_ERRORS = {"invalid": Invalid, "not_found": NotFound, "unavailable": Unavailable}


class Disconnected(ConnectionError):
    """The other end closed the connection before or in the middle of a message."""


def raise_refusal(reply: dict[str, Any]) -> None:
    """Raise what a reply's header says went wrong, if anything did."""
    if reply.get("ok") is not True:
        kind = _ERRORS.get(str(reply.get("kind")), Unavailable)
        raise kind(str(reply.get("detail", "The inference process gave no reason.")))


def head_of(header: dict[str, Any], n_bytes: int) -> bytes:
    """Return the bytes of a message before its ``n_bytes`` raw bytes."""
    text = json.dumps({**header, "n_bytes": n_bytes}).encode()
    return _LENGTH.pack(len(text)) + text


def header_length_of(data: bytes | bytearray) -> int:
    """Return the length of the header from a message's first 4 bytes; raises Invalid."""
    length: int = _LENGTH.unpack(data)[0]
    if length > MAX_HEADER_BYTES:
        raise Invalid(f"Expected a header of at most {MAX_HEADER_BYTES} bytes, got {length}.")
    return length


def parse_header(data: bytes | bytearray) -> tuple[dict[str, Any], int]:
    """Return a header and the number of raw bytes after it; raises Invalid."""
    try:
        header = json.loads(data)
    except ValueError as problem:
        raise Invalid("The message's header is not JSON.") from problem
    if not isinstance(header, dict):
        raise Invalid("The message's header is not a JSON object.")
    n_bytes = header.get("n_bytes")
    if not isinstance(n_bytes, int) or not 0 <= n_bytes <= MAX_BODY_BYTES:
        raise Invalid(f"Expected at most {MAX_BODY_BYTES} bytes, the message announces {n_bytes}.")
    return header, n_bytes


def send_message(connection: socket.socket, header: dict[str, Any], body: bytes = b"") -> None:
    """Send one message."""
    connection.sendall(head_of(header, len(body)))
    if body:  # even an empty write fails once the other end has answered and closed
        connection.sendall(body)


def receive_message(connection: socket.socket) -> tuple[dict[str, Any], bytearray]:
    """Receive one message: its header and its bytes.

    Raises:
        Disconnected: The other end closed the connection.
        Invalid: The message is malformed or too long.
    """
    length = header_length_of(receive_exactly(connection, LENGTH_BYTES))
    header, n_bytes = parse_header(receive_exactly(connection, length))
    return header, receive_exactly(connection, n_bytes)


def receive_exactly(
    connection: socket.socket, n_bytes: int, within_s: float | None = None
) -> bytearray:
    """Receive so many bytes.

    Args:
        connection: The connection.
        n_bytes: Number of bytes.
        within_s: Timeout for all bytes; None for the timeout of each part only.

    Raises:
        Disconnected: The other end closed the connection before.
        TimeoutError: They take too long.
    """
    deadline = None if within_s is None else time.monotonic() + within_s
    content = bytearray(n_bytes)
    view, n_received = memoryview(content), 0
    while n_received < n_bytes:
        if deadline is not None:
            connection.settimeout(max(0.001, deadline - time.monotonic()))
        count = connection.recv_into(view[n_received:])
        if count == 0:
            raise Disconnected("The connection was closed.")
        n_received += count
    return content
