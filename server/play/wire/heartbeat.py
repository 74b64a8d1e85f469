"""The heartbeat of a page's connection: browsers do not tell pages of the WebSocket's own pings."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import asynccontextmanager

from server.play.wire.protocol import Alive

BEAT_EVERY_S = 1.0


@asynccontextmanager
async def heartbeat(send: Callable[[Alive], Awaitable[None]]) -> AsyncIterator[None]:
    """Send a message once a second for a block, also while a game is loaded or stands still."""

    async def beat() -> None:
        while True:
            await asyncio.sleep(BEAT_EVERY_S)
            await send(Alive())

    beating = asyncio.create_task(beat(), name="heartbeat")
    try:
        yield
    finally:
        beating.cancel()
