"""The change stream: one reader of the database per process, however many pages listen."""

from __future__ import annotations

import asyncio
import json
import logging
import threading
from collections.abc import AsyncIterator

from sqlalchemy.exc import SQLAlchemyError

from tril.store.changes import ChangeReader, prune
from tril.store.database import Database

_LOG = logging.getLogger(__name__)

POLL_S = 0.5
PING_S = 15.0
PRUNE_EVERY_POLLS = 1200

Change = tuple[str, str]
"""(topic, key)"""


class _Listener:
    """Changes not yet sent to one page; a repeated change is sent once."""

    def __init__(self) -> None:
        self.pending: dict[Change, None] = {}
        self.woken = asyncio.Event()


class ChangeStream:
    """Polls the table of changes in a thread and passes new ones to every listener.

    Args:
        database: Where the changes are.
        poll_s: Seconds between polls.
    """

    def __init__(self, database: Database, poll_s: float = POLL_S) -> None:
        self._database = database
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

    async def stream(self) -> AsyncIterator[str]:
        """Yield changes from now on, as server-sent events."""
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
                changes, listener.pending = listener.pending, {}
                for topic, key in changes:
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
        for listener in self._listeners:
            listener.pending.update(dict.fromkeys(changes))
            listener.woken.set()
