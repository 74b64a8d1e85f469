"""Asks the inference process from the event loop, over one connection that stays open."""

from __future__ import annotations

import asyncio
from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from tril.inference import AttentionMap, AttentionNetwork, Endpoint, Judgement
from tril.inference.endpoint import Streams, disconnect
from tril.inference.messages import (
    LENGTH_BYTES,
    head_of,
    header_length_of,
    parse_header,
    raise_refusal,
)
from tril.play.observation import SIZE, STACK, Observation, Observations

TIMEOUT_S = 20.0
"""Loading the networks of a run for the first time takes most of a second."""


_NO_OBSERVATIONS = np.empty((0, STACK, SIZE, SIZE), np.uint8)


class PolicyClient:
    """Asks one run's networks for actions, rewards and attention maps.

    A request whose connection turns out to be closed is repeated once on a new one, because the
    process may have been restarted, or closed it after a long pause.

    Args:
        endpoint: Where the inference process answers.
        run_id: The run.
        timeout_s: Seconds that a reply may take.
    """

    def __init__(self, endpoint: Endpoint, run_id: str, timeout_s: float = TIMEOUT_S) -> None:
        self._endpoint = endpoint
        self._run_id = run_id
        self._timeout_s = timeout_s
        self._lock = asyncio.Lock()
        self._opened: Streams | None = None
        self._scale: tuple[float, float] | None = None

    async def act(
        self, policies: Sequence[str], observations: Observations
    ) -> npt.NDArray[np.float32]:
        """Return the probability of each action, float32 (N, n_actions).

        Args:
            policies: The policy that is asked about each observation.
            observations: uint8 (N, 4, 84, 84).

        Raises:
            NotFound: The run has no such policy.
            Unavailable: The process does not reply.
        """
        _, values = await self._ask({"op": "act", "policies": list(policies)}, observations)
        return np.frombuffer(values, np.float32).reshape(len(observations), -1)

    async def judge(self, observations: Observations) -> Judgement:
        """Return R of observations, uint8 (N, 4, 84, 84); raises as ``act``."""
        _, values = await self._ask({"op": "judge"}, observations)
        return Judgement.of(np.frombuffer(values, np.float32).reshape(2, len(observations)))

    async def attention(
        self, network: AttentionNetwork, observation: Observation, background: int
    ) -> AttentionMap:
        """Return a network's attention map of an observation, uint8 (4, 84, 84), by the gradient.

        The background is the gray of the game's.

        Raises as ``act``.
        """
        request = {
            "op": "attention",
            "network": network,
            "method": "gradient",
            "background": background,
        }
        return AttentionMap.of(*await self._ask(request, observation[None]))

    async def scale(self) -> tuple[float, float]:
        """Return R at which the level is 0, and R at which it is 1; raises as ``act``."""
        if self._scale is None:
            _, values = await self._ask({"op": "scale"}, _NO_OBSERVATIONS)
            zero_level, unit_level = np.frombuffer(values, np.float32).tolist()
            self._scale = zero_level, unit_level
        return self._scale

    def close(self) -> None:
        """Close the connection."""
        if self._opened is not None:
            disconnect(self._opened[1])
            self._opened = None

    async def _ask(
        self, request: dict[str, Any], observations: Observations
    ) -> tuple[dict[str, Any], bytes]:
        request = {**request, "run_id": self._run_id}
        message = head_of(request, observations.nbytes) + observations.tobytes()
        async with self._lock:
            try:
                async with asyncio.timeout(self._timeout_s):
                    header, values = await self._exchange(message)
            except (OSError, asyncio.IncompleteReadError) as problem:
                self.close()
                lost = problem if isinstance(problem, OSError) else ConnectionError(str(problem))
                raise self._endpoint.unavailable(lost) from problem
            except BaseException:
                # A reply that is still to come would be taken for that to the next request.
                self.close()
                raise
        raise_refusal(header)
        return header, values

    async def _exchange(self, message: bytes) -> tuple[dict[str, Any], bytes]:
        try:
            return await self._exchange_once(message)
        except (ConnectionError, asyncio.IncompleteReadError):
            self.close()
            return await self._exchange_once(message)

    async def _exchange_once(self, message: bytes) -> tuple[dict[str, Any], bytes]:
        if self._opened is None:
            self._opened = await self._endpoint.open()
        reader, writer = self._opened
        writer.write(message)
        await writer.drain()
        length = header_length_of(await reader.readexactly(LENGTH_BYTES))
        header, n_bytes = parse_header(await reader.readexactly(length))
        return header, await reader.readexactly(n_bytes)
