"""Client of the inference process, and the protocol of both ends.

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
- ``{"op": "attention", "run_id", "network", "method"}`` gives the attention map of one observation,
  float32 (84, 84), and in the reply's header the ``action`` that a policy would choose, null of a
  reward model. The work ends when the client disconnects.

A reply is ``{"ok": true}`` with the values or ``{"ok": false, "kind", "detail"}``.
"""

from __future__ import annotations

import json
import os
import select
import socket
import struct
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from tril.errors import Invalid, NotFound, Unavailable
from tril.game.observation import (
    OBSERVATION_SHAPE,
    SIZE,
    Observation,
    Observations,
    check_observations,
)
from tril.game.space_invaders import Action

MAX_HEADER_BYTES = 16 * 1024
MAX_OBSERVATIONS = 1024
OBSERVATION_BYTES = int(np.prod(OBSERVATION_SHAPE))
MAX_BODY_BYTES = MAX_OBSERVATIONS * OBSERVATION_BYTES
TIMEOUT_S = 60.0
LONGEST_ADDRESS = 100
"""Bytes of a path that fit into the address of a local socket, with some margin."""

_LENGTH = struct.Struct("<I")
LENGTH_BYTES = _LENGTH.size
_ERRORS = {"invalid": Invalid, "not_found": NotFound, "unavailable": Unavailable}

GIVEN_UP_POLL_S = 0.05
"""How often a client that may give up looks whether to."""

Values = npt.NDArray[np.float32]


@dataclass(frozen=True)
class Judgement:
    """What a reward model says of observations.

    Attributes:
        rewards: R, float32 (N,).
        deviations: The standard deviation of R, float32 (N,); None if the model does not know it.
    """

    rewards: Values
    deviations: Values | None

    @classmethod
    def of(cls, values: Values) -> Judgement:
        """Return what the process answered, float32 (2, N), NaN where nothing is known."""
        return cls(values[0], None if np.isnan(values[1]).any() else values[1])


AttentionMethod = Literal["gradient", "occlusion", "patches"]
"""How attention is mapped: at once by the gradient, by occlusion of 3x3 pixels of one screen, as
published, or by patches of 9x9 pixels of all four."""

AttentionNetwork = Literal["reward", "imitator", "clone"]
"""Whose attention is mapped."""


@dataclass(frozen=True)
class AttentionMap:
    """What a network looks at in a state.

    Attributes:
        values: float32 (84, 84), non-negative. By the gradient and by occlusion the sum over the
            observation's screens.
        action: The action that a policy would choose, whose log odds the map explains; None of a
            reward model, whose R it explains.
    """

    values: Values
    action: Action | None

    @classmethod
    def of(cls, header: Mapping[str, Any], values: bytes | bytearray) -> AttentionMap:
        """Return what the process answered: the header, and float32 (84, 84)."""
        action = header.get("action")
        return cls(
            np.frombuffer(values, np.float32).reshape(SIZE, SIZE),
            None if action is None else Action(action),
        )


class GivenUp(Exception):
    """Nobody waits for the reply any more."""


class Disconnected(ConnectionError):
    """The other end closed the connection before or in the middle of a message."""


class InferenceClient:
    """Requests R of trained reward models from the inference process.

    Threads may share it. A request whose connection breaks is repeated once, because the process
    may just have been restarted.

    Args:
        path: The process's socket (Settings.inference_socket).
        timeout_s: Seconds that a reply may take.
    """

    def __init__(self, path: Path, timeout_s: float = TIMEOUT_S) -> None:
        self._path = path
        self._timeout_s = timeout_s

    def ping(self) -> None:
        """Check that the process replies; raises Unavailable otherwise."""
        self._request({"op": "ping"})

    def judge(self, run_id: str, observations: Observations) -> Judgement:
        """Return R of observations, uint8 (N, 4, 84, 84), by a run's reward model.

        Raises:
            NotFound: The run has no reward model.
            Unavailable: The process does not reply.
        """
        request = {"op": "judge", "run_id": run_id}
        parts = [self._request(request, part) for part in _parts(observations)]
        values = [np.frombuffer(part, np.float32).reshape(2, -1) for part in parts]
        return Judgement.of(np.concatenate(values, axis=1))

    def scale(self, run_id: str) -> tuple[float, float]:
        """Return R at which a run's level is 0, and R at which it is 1.

        Raises:
            NotFound: The run has no reward model.
            Unavailable: The process does not reply.
        """
        values = np.frombuffer(self._request({"op": "scale", "run_id": run_id}), np.float32)
        zero, one = values.tolist()
        return zero, one

    def attention(
        self,
        run_id: str,
        observation: Observation,
        network: AttentionNetwork,
        method: AttentionMethod,
        is_given_up: Callable[[], bool],
    ) -> AttentionMap:
        """Return the attention map of one of a run's networks.

        Args:
            run_id: The run.
            observation: uint8 (4, 84, 84).
            network: Whose.
            method: How.
            is_given_up: Whether nobody waits for the map any more; the process then drops it.

        Raises:
            NotFound: The run has no such network.
            Unavailable: The process does not reply.
            GivenUp: ``is_given_up`` said so.
        """
        request = {"op": "attention", "run_id": run_id, "network": network, "method": method}
        return AttentionMap.of(*self._exchange(request, _checked(observation[None]), is_given_up))

    def _request(self, request: dict[str, Any], body: bytes = b"") -> bytearray:
        return self._exchange(request, body)[1]

    def _exchange(
        self,
        request: dict[str, Any],
        body: bytes,
        is_given_up: Callable[[], bool] | None = None,
    ) -> tuple[dict[str, Any], bytearray]:
        try:
            try:
                return self._exchange_once(request, body, is_given_up)
            except ConnectionError:
                return self._exchange_once(request, body, is_given_up)
        except OSError as problem:
            raise unavailable(problem) from problem

    def _exchange_once(
        self, request: dict[str, Any], body: bytes, is_given_up: Callable[[], bool] | None
    ) -> tuple[dict[str, Any], bytearray]:
        with socket.socket(socket.AF_UNIX) as connection:
            connection.settimeout(self._timeout_s)
            with address_of(self._path) as address:
                connection.connect(address)
            send_message(connection, request, body)
            if is_given_up is not None:
                self._await_reply(connection, is_given_up)
            header, values = receive_message(connection)
        raise_refusal(header)
        return header, values

    def _await_reply(self, connection: socket.socket, is_given_up: Callable[[], bool]) -> None:
        deadline = time.monotonic() + self._timeout_s
        poll = select.poll()
        poll.register(connection, select.POLLIN)
        while not poll.poll(GIVEN_UP_POLL_S * 1000):
            if is_given_up():
                raise GivenUp
            if time.monotonic() > deadline:
                raise TimeoutError


def raise_refusal(reply: dict[str, Any]) -> None:
    """Raise what a reply's header says went wrong, if anything did."""
    if reply.get("ok") is not True:
        kind = _ERRORS.get(str(reply.get("kind")), Unavailable)
        raise kind(str(reply.get("detail", "The inference process gave no reason.")))


def unavailable(problem: OSError) -> Unavailable:
    """Return the error that tells a person of a process that can't be reached."""
    reason = "did not answer in time" if isinstance(problem, TimeoutError) else "is not running"
    return Unavailable(
        f"The inference process {reason}, so no network can be asked. `tril up` starts it, "
        "again if need be; try again in a moment."
    )


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
    length = header_length_of(_exactly(connection, LENGTH_BYTES))
    header, n_bytes = parse_header(_exactly(connection, length))
    return header, _exactly(connection, n_bytes)


def _exactly(connection: socket.socket, n_bytes: int) -> bytearray:
    content = bytearray(n_bytes)
    view, got = memoryview(content), 0
    while got < n_bytes:
        count = connection.recv_into(view[got:])
        if count == 0:
            raise Disconnected("The connection was closed.")
        got += count
    return content


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


def _parts(observations: Observations) -> Iterator[bytes]:
    for begin in range(0, max(1, len(observations)), MAX_OBSERVATIONS):
        yield _checked(observations[begin : begin + MAX_OBSERVATIONS])


def _checked(observations: Observations) -> bytes:
    try:
        check_observations(observations)
    except ValueError as error:
        raise Invalid(str(error)) from None
    return np.ascontiguousarray(observations).tobytes()
