"""Bounds on how many requests work at the same time."""

from __future__ import annotations

import asyncio
from collections import Counter, OrderedDict, deque
from collections.abc import AsyncIterator, Hashable
from contextlib import asynccontextmanager

from fastapi import HTTPException

RETRY_AFTER_S = 5


class ConcurrencyLimit:
    """Lets some requests work at once; the others wait, clients in turn and those of each in order.

    A request that waits holds neither a thread nor a connection to the database.

    Args:
        at_once: Most requests at work.
        per_client: Most requests of one client at work.
        waiting: Most waiting requests of one client.
        wait_s: Longest wait of a request.
    """

    def __init__(self, at_once: int, per_client: int, waiting: int, wait_s: float) -> None:
        self._n_free = at_once
        self._per_client = per_client
        self._places = waiting
        self._wait_s = wait_s
        self._at_work: Counter[Hashable] = Counter()
        self._waiting: OrderedDict[Hashable, deque[asyncio.Future[None]]] = OrderedDict()

    @asynccontextmanager
    async def slot(self, client: Hashable) -> AsyncIterator[None]:
        """Wait for a slot and hold it for the block.

        Args:
            client: The client that asks.

        Raises:
            HTTPException: 503, because too many of the client's requests wait or this one has
                waited for too long.
        """
        await self._acquire(client)
        try:
            yield
        finally:
            self._release(client)

    async def _acquire(self, client: Hashable) -> None:
        queue = self._waiting.setdefault(client, deque())
        if len(queue) >= self._places:
            raise _too_busy()
        turn = asyncio.get_running_loop().create_future()
        queue.append(turn)
        self._grant_slots()
        try:
            async with asyncio.timeout(self._wait_s):
                await turn
        except TimeoutError:
            self._give_up(client, turn)
            raise _too_busy() from None
        except asyncio.CancelledError:
            self._give_up(client, turn)
            raise

    def _give_up(self, client: Hashable, turn: asyncio.Future[None]) -> None:
        if turn.cancelled():
            self._forget(client, turn)
        else:
            # The turn has come in the same moment.
            self._release(client)

    def _release(self, client: Hashable) -> None:
        self._n_free += 1
        self._at_work[client] -= 1
        if not self._at_work[client]:
            del self._at_work[client]
        self._grant_slots()

    def _grant_slots(self) -> None:
        """Give free slots to waiting requests."""
        for client in list(self._waiting):
            if not self._n_free:
                return
            if self._at_work[client] >= self._per_client:
                continue
            turn = next((turn for turn in self._waiting[client] if not turn.done()), None)
            if turn is None:
                # Those who waited are about to forget their turns.
                continue
            self._forget(client, turn)
            if client in self._waiting:
                self._waiting.move_to_end(client)
            self._n_free -= 1
            self._at_work[client] += 1
            turn.set_result(None)

    def _forget(self, client: Hashable, turn: asyncio.Future[None]) -> None:
        self._waiting[client].remove(turn)
        if not self._waiting[client]:
            del self._waiting[client]


def _too_busy() -> HTTPException:
    return HTTPException(
        503,
        "The server has too much to do at the moment. Try again in a few seconds.",
        {"Retry-After": str(RETRY_AFTER_S)},
    )
