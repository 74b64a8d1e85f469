"""What a session does at the moment: at most one task, which can be stopped."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Awaitable, Callable, Coroutine

_LOG = logging.getLogger(__name__)


class Activity:
    """Runs one task of a session at a time, and reports its unexpected errors.

    Args:
        name: Name of the tasks, for the log.
        on_error: Called after an unexpected error was logged.

    Attributes:
        stop_requested: Set while somebody waits for the task to stop.
    """

    def __init__(self, name: str, on_error: Callable[[], Awaitable[None]]) -> None:
        self.stop_requested = asyncio.Event()
        self._name = name
        self._on_error = on_error
        self._task: asyncio.Task[None] | None = None

    @property
    def is_running(self) -> bool:
        """Whether there is a task that has not called ``finish``."""
        return self._task is not None

    def start(self, work: Coroutine[None, None, None]) -> None:
        """Run a coroutine as the task."""
        self._task = asyncio.create_task(self._run(work), name=self._name)

    def finish(self) -> None:
        """Let another task start while the current one winds up."""
        self._task = None

    async def join(self) -> None:
        """Wait until the task has ended."""
        if self._task is not None:
            await asyncio.wait([self._task])

    async def stop(self) -> None:
        """Ask the task to stop and wait until it has, unless called from within it."""
        if self._task is not asyncio.current_task() and self._task is not None:
            self.stop_requested.set()
            await asyncio.wait([self._task])
            self.stop_requested.clear()

    async def _run(self, work: Coroutine[None, None, None]) -> None:
        try:
            await work
        except Exception:  # noqa: BLE001
            _LOG.exception("An unexpected error in %s.", self._name)
            await self._on_error()
