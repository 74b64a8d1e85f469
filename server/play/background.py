"""Periodic background tasks that survive their errors."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Awaitable, Callable

from tril.errors import Unavailable

_LOG = logging.getLogger(__name__)

FIRST_PAUSE_S = 1.0
LONGEST_PAUSE_S = 30.0


class PeriodicTask:
    """Runs a coroutine function periodically, against absolute deadlines.

    An exception is logged and the function run again, after a pause that doubles with every
    failure in a row.

    Args:
        name: Name in the log and in the server's health.
        work: The coroutine function.
        period_s: Seconds from one run's begin to the next.
        at_once: Whether the first run is due at the start instead of a period later.

    Attributes:
        name: The name.
        n_failures: Failures in a row; 0 after a success.
    """

    def __init__(
        self,
        name: str,
        work: Callable[[], Awaitable[None]],
        period_s: float,
        at_once: bool = False,
    ) -> None:
        self.name = name
        self.n_failures = 0
        self._work = work
        self._period_s = period_s
        self._at_once = at_once
        self._task: asyncio.Task[None] | None = None

    @property
    def is_healthy(self) -> bool:
        """Whether the task runs and its last run succeeded."""
        return self._task is not None and not self._task.done() and self.n_failures == 0

    def start(self) -> None:
        """Start the task in the running event loop."""
        self._task = asyncio.create_task(self._run(), name=self.name)

    async def stop(self) -> None:
        """Cancel the task and wait for its end."""
        if self._task is not None:
            self._task.cancel()
            await asyncio.wait([self._task])

    async def _run(self) -> None:
        loop = asyncio.get_running_loop()
        next_run = loop.time() + (0.0 if self._at_once else self._period_s)
        while True:
            await asyncio.sleep(max(0.0, next_run - loop.time()))
            try:
                await self._work()
            except Unavailable as error:
                self.n_failures += 1
                _LOG.warning("The task %r failed: %s", self.name, error)
            except Exception:  # noqa: BLE001
                self.n_failures += 1
                _LOG.exception("The task %r failed; it is run again.", self.name)
            else:
                self.n_failures = 0
            next_run = max(next_run + self._period_s, loop.time() + self._pause_s())

    def _pause_s(self) -> float:
        if not self.n_failures:
            return 0.0
        return min(LONGEST_PAUSE_S, FIRST_PAUSE_S * 2.0 ** min(self.n_failures - 1, 10))
