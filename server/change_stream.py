"""The change stream: one reader of the database per process, however many pages listen."""

from __future__ import annotations

import asyncio
import json
import logging
import threading
from collections.abc import AsyncIterator, Awaitable, Callable, Collection
from contextlib import AbstractContextManager, nullcontext

from sqlalchemy.exc import SQLAlchemyError

from tril.store.changes import LIBRARY_CHANGED, ChangeReader, prune
from tril.store.database import Database

_LOG = logging.getLogger(__name__)

POLL_S = 0.5
PING_S = 5.0
"""Longest silence. A page that hears nothing for longer listens again."""
PRUNE_EVERY_POLLS = 1200

Change = tuple[str, str]
"""(topic, key)"""


MOST_RECORDINGS = 50
"""Most changed recordings that a page is told of one by one; beyond that, of libraries."""


def _coalesced(changes: Collection[Change]) -> Collection[Change]:
    other_changes = [change for change in changes if change[0] != "recording"]
    if len(changes) - len(other_changes) <= MOST_RECORDINGS:
        return changes
    return [*other_changes, (LIBRARY_CHANGED, "")]


class _Listener:
    """Changes not yet sent to one page; a repeated change is sent once."""

    def __init__(self) -> None:
        self.pending: dict[Change, None] = {}
        self.woken = asyncio.Event()
        self.has_ended = False

    def end(self) -> None:
        """End the stream."""
        self.has_ended = True
        self.woken.set()


class ChangeStream:
    """Polls the table of changes in a thread and passes new ones to every listener.

    Args:
        database: Where the changes are.
        on_change: Is called in the event loop with what changed, before the listeners are.
        poll_s: Seconds between polls.
    """

    def __init__(
        self,
        database: Database,
        on_change: Callable[[Collection[Change]], None] = lambda _: None,
        poll_s: float = POLL_S,
    ) -> None:
        self._database = database
        self._on_change = on_change
        self._poll_s = poll_s
        self._listeners: set[_Listener] = set()
        self._stopped = threading.Event()
        self._closed = False
        self._thread = threading.Thread(target=self._poll, name="changes", daemon=True)

    def start(self) -> None:
        """Start polling; call it in the event loop that the listeners run in."""
        self._loop = asyncio.get_running_loop()
        # Before anybody listens, so that no change that they wait for counts as old.
        with self._database.reading() as session:
            self._reader = ChangeReader(session)
        self._thread.start()

    def close(self) -> None:
        """End every stream, so that a server that stops does not wait for them."""
        self._closed = True
        for listener in self._listeners:
            listener.woken.set()

    def stop(self) -> None:
        """End every stream and stop polling."""
        self.close()
        self._stopped.set()
        if self._thread.is_alive():
            self._thread.join()

    async def stream(
        self,
        visible: Callable[[Collection[Change]], Awaitable[Collection[Change]]] | None = None,
        until_ended: Callable[[Callable[[], None]], AbstractContextManager[None]] = (
            lambda _: nullcontext()
        ),
    ) -> AsyncIterator[str]:
        """Yield changes from now on, as server-sent events.

        Args:
            visible: Returns those of some changes that the listener may know of; None for all.
            until_ended: Calls a function, within its block, if the stream has to end.
        """
        listener = _Listener()
        self._listeners.add(listener)
        with until_ended(listener.end):
            async for text in self._events(listener, visible):
                yield text

    async def _events(
        self,
        listener: _Listener,
        visible: Callable[[Collection[Change]], Awaitable[Collection[Change]]] | None,
    ) -> AsyncIterator[str]:
        try:
            yield "retry: 1000\n\n: listening\n\n"
            while not (self._closed or listener.has_ended):
                try:
                    await asyncio.wait_for(listener.woken.wait(), PING_S)
                except TimeoutError:
                    yield "event: ping\ndata\n\n"
                    continue
                listener.woken.clear()
                pending, listener.pending = listener.pending, {}
                changes = list(pending) if visible is None else await visible(list(pending))
                for topic, key in _coalesced(changes):
                    data = json.dumps({"topic": topic, "key": key})
                    yield f"event: change\ndata: {data}\n\n"
        finally:
            self._listeners.discard(listener)

    def _poll(self) -> None:
        polls = 0
        while not self._stopped.wait(self._poll_s):
            try:
                with self._database.reading() as session:
                    rows = self._reader.read(session)
                if rows:
                    changes = [(row.topic, row.key) for row in rows]
                    self._loop.call_soon_threadsafe(self._publish, changes)
                polls += 1
                if polls % PRUNE_EVERY_POLLS == 0:
                    with self._database.writing() as session:
                        prune(session)
            except SQLAlchemyError as error:
                _LOG.warning("Changes could not be read; trying again: %s", error)

    def _publish(self, changes: list[Change]) -> None:
        self._on_change(changes)
        for listener in self._listeners:
            listener.pending.update(dict.fromkeys(changes))
            listener.woken.set()
