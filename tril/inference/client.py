"""Client of the inference process."""

from __future__ import annotations

import select
import socket
import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from tril.errors import Invalid
from tril.inference.endpoint import Endpoint
from tril.inference.messages import (
    MAX_OBSERVATIONS,
    raise_refusal,
    receive_message,
    send_message,
)
from tril.play.observation import (
    SIZE,
    Observation,
    Observations,
    check_observations,
)

TIMEOUT_S = 60.0

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
        """Parse a response, float32 (2, N), NaN where nothing is known."""
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
    action: int | None

    @classmethod
    def of(cls, header: Mapping[str, Any], values: bytes | bytearray) -> AttentionMap:
        """Parse a response: the header, and float32 (84, 84)."""
        action = header.get("action")
        return cls(
            np.frombuffer(values, np.float32).reshape(SIZE, SIZE),
            None if action is None else int(action),
        )


class GivenUp(Exception):
    """Nobody waits for the reply any more."""


class InferenceClient:
    """Requests R of trained reward models from the inference process.

    Threads may share it. A request whose connection breaks is repeated once, because the process
    may just have been restarted.

    Args:
        endpoint: Where the process answers.
        timeout_s: Seconds that a reply may take.
    """

    def __init__(self, endpoint: Endpoint, timeout_s: float = TIMEOUT_S) -> None:
        self._endpoint = endpoint
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
        offset, scale = values.tolist()
        return offset, scale

    def attention(
        self,
        run_id: str,
        observation: Observation,
        network: AttentionNetwork,
        method: AttentionMethod,
        is_given_up: Callable[[], bool],
        background: int = 0,
    ) -> AttentionMap:
        """Return the attention map of one of a run's networks.

        Args:
            run_id: The run.
            observation: uint8 (4, 84, 84).
            network: Network to explain.
            method: Method of the map.
            is_given_up: Whether nobody waits for the map any more; the process then drops it.
            background: Gray of the game's background, 0 to 255.

        Raises:
            NotFound: The run has no such network.
            Unavailable: The process does not reply.
            GivenUp: ``is_given_up`` said so.
        """
        request = {
            "op": "attention",
            "run_id": run_id,
            "network": network,
            "method": method,
            "background": background,
        }
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
            raise self._endpoint.unavailable(problem) from problem

    def _exchange_once(
        self, request: dict[str, Any], body: bytes, is_given_up: Callable[[], bool] | None
    ) -> tuple[dict[str, Any], bytearray]:
        with self._endpoint.connect(self._timeout_s) as connection:
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


def _parts(observations: Observations) -> Iterator[bytes]:
    for begin in range(0, max(1, len(observations)), MAX_OBSERVATIONS):
        yield _checked(observations[begin : begin + MAX_OBSERVATIONS])


def _checked(observations: Observations) -> bytes:
    try:
        check_observations(observations)
    except ValueError as error:
        raise Invalid(str(error)) from None
    return np.ascontiguousarray(observations).tobytes()
