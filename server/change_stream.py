"""One watcher of the database per process, whatever the number of pages that listen."""

from __future__ import annotations

import asyncio
import json
import logging
import threading
from collections.abc import AsyncIterator

from sqlalchemy.exc import SQLAlchemyError

from tril.store.changes import changes_after, last_change, prune
from tril.store.database import Database

_LOG = logging.getLogger(__name__)

POLL_S = 0.5
PING_S = 15.0
PRUNE_EVERY_POLLS = 1200

Change = tuple[str, str]
"""(topic, key)"""


class _Listener:
    """What one page has not been told yet; the same thing is told once however often it changed."""

    def __init__(self) -> None:
        self.pending: dict[Change, None] = {}
        self.woken = asyncio.Event()


class ChangeStream:
    """Watches the table of changes in a thread and tells every listener.

    Args:
        database: Where the changes are.
        poll_s: Seconds between looks.
    """

    def __init__(self, database: Database, poll_s: float = POLL_S) -> None:
        self._database = database
        self._poll_s = poll_s
        self._listeners: set[_Listener] = set()
        self._loop: asyncio.AbstractEventLoop | None = None
        self._stopped = threading.Event()
        self._closed = False
        self._last = 0
        self._thread = threading.Thread(target=self._watch, name="changes", daemon=True)

    def start(self) -> None:
        """Begin to watch; call it in the event loop that listeners will run in."""
        self._loop = asyncio.get_running_loop()
        # Before anybody listens, so that nothing that they wait for is taken for old.
        with self._database.reading() as session:
            self._last = last_change(session)
        self._thread.start()

    def close(self) -> None:
        """End every stream, so that a server that stops does not wait for them."""
        self._closed = True
        for listener in self._listeners:
            listener.woken.set()

    def stop(self) -> None:
        """End every stream and stop watching."""
        self.close()
        self._stopped.set()
        if self._thread.is_alive():
            self._thread.join()

    async def stream(self) -> AsyncIterator[str]:
        """Yield what changes from now on, as server-sent events."""
        listener = _Listener()
        self._listeners.add(listener)
        try:
            yield "retry: 1000\n\n: listening\n\n"
            while not self._closed:
                try:
                    await asyncio.wait_for(listener.woken.wait(), PING_S)
                except TimeoutError:
                    yield ": ping\n\n"
                    continue
                listener.woken.clear()
                told, listener.pending = listener.pending, {}
                for topic, key in told:
                    data = json.dumps({"topic": topic, "key": key})
                    yield f"event: change\ndata: {data}\n\n"
        finally:
            self._listeners.discard(listener)

    def _watch(self) -> None:
        polls = 0
        while not self._stopped.wait(self._poll_s):
            try:
                self._look()
                polls += 1
                if polls % PRUNE_EVERY_POLLS == 0:
                    with self._database.writing() as session:
                        prune(session)
            except SQLAlchemyError as error:
                _LOG.warning("Changes could not be read and will be looked for again: %s", error)

    def _look(self) -> None:
        with self._database.reading() as session:
            found = changes_after(session, self._last)
        if found and self._loop is not None:
            self._last = found[-1].id
            told = [(change.topic, change.key) for change in found]
            self._loop.call_soon_threadsafe(self._tell, told)

    def _tell(self, changes: list[Change]) -> None:
        for listener in self._listeners:
            listener.pending.update(dict.fromkeys(changes))
            listener.woken.set()
