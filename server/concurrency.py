"""Bounds on how many requests work at the same time."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

from fastapi import HTTPException

RETRY_AFTER_S = 5


class ConcurrencyLimit:
    """Lets some requests work at once; the others wait in the order in which they came.

    A request that waits holds neither a thread nor a connection to the database.

    Args:
        at_once: Most requests that work.
        waiting: Most that wait.
        wait_s: How long one waits.
    """

    def __init__(self, at_once: int, waiting: int, wait_s: float) -> None:
        self._free = asyncio.Semaphore(at_once)
        self._places = waiting
        self._wait_s = wait_s

    @asynccontextmanager
    async def slot(self) -> AsyncIterator[None]:
        """Wait for a slot and hold it for the block.

        Raises:
            HTTPException: 503, because too many requests wait or this one has waited for too long.
        """
        await self._acquire()
        try:
            yield
        finally:
            self._free.release()

    async def _acquire(self) -> None:
        if not self._places:
            raise _too_busy()
        self._places -= 1
        try:
            async with asyncio.timeout(self._wait_s):
                await self._free.acquire()
        except TimeoutError:
            raise _too_busy() from None
        finally:
            self._places += 1


def _too_busy() -> HTTPException:
    return HTTPException(
        503,
        "The server has too much to do at the moment. Try again in a few seconds.",
        {"Retry-After": str(RETRY_AFTER_S)},
    )
