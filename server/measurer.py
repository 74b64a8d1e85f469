"""Measures recordings in the background, whenever a behaviour asks for what is not stored yet."""

from __future__ import annotations

import asyncio
import logging
import random
import threading
import time
from concurrent.futures import ThreadPoolExecutor

from server.play.background import PeriodicTask
from server.play.replays import ReplayProcess
from tril.errors import Invalid, NotFound, Unavailable
from tril.games.measures import Measure
from tril.games.measuring import Values, measurable
from tril.store import measured, recordings
from tril.store.changes import LIBRARY_CHANGED
from tril.store.database import Database

_LOG = logging.getLogger(__name__)

PERIOD_S = 1.0
STORED_EVERY_S = 2.0
STORED_AT_ONCE = 50
"""Recordings whose values are stored in one transaction at most: pages are told of each."""
TOPICS = frozenset({"behaviour", "recording", "ranking", "run", LIBRARY_CHANGED})
"""Changes after which values may be missing."""


class Measurer:
    """Replays verified recordings that lack a value, one at a time.

    Several servers may measure the same recording; they store the same values.

    Args:
        database: The application's database.
        replays: The process that replays recordings.
    """

    def __init__(self, database: Database, replays: ReplayProcess) -> None:
        self._database = database
        self._replays = replays
        self._wanted = True
        self._stopping = threading.Event()
        self._refused: set[tuple[int, tuple[Measure, ...]]] = set()
        self._thread = ThreadPoolExecutor(1, thread_name_prefix="measures")
        self._task = PeriodicTask("measures", self._work, PERIOD_S, at_once=True)

    def start(self) -> None:
        """Start to measure in the running event loop."""
        self._task.start()

    def wake(self) -> None:
        """Look for missing values again; thread-safe."""
        self._wanted = True

    async def stop(self) -> None:
        """Stop after the recording that is measured."""
        self._stopping.set()
        await self._task.stop()
        await asyncio.to_thread(self._thread.shutdown)

    async def _work(self) -> None:
        if not self._wanted:
            return
        self._wanted = False
        try:
            await asyncio.get_running_loop().run_in_executor(self._thread, self.measure_all)
        except Exception:
            self._wanted = True
            raise

    def measure_all(self) -> None:
        """Measure all that is missing."""
        with self._database.reading() as session:
            missing = list(measured.unmeasured(session).items())
        # In any order, so that servers that measure side by side seldom do the same.
        random.Random().shuffle(missing)
        values: dict[int, Values] = {}
        stored_s = time.monotonic()
        for recording_id, measures in missing:
            if self._stopping.is_set():
                break
            if (recording_id, measures) in self._refused:
                continue
            try:
                values[recording_id] = self._values(recording_id, measures)
            except (Invalid, NotFound) as refusal:
                self._refused.add((recording_id, measures))
                _LOG.warning("Recording %d can't be measured: %s", recording_id, refusal)
            except Unavailable as failure:
                # Tried again after the next change; the others don't wait for it.
                _LOG.warning("Recording %d is not measured yet: %s", recording_id, failure)
            is_due = time.monotonic() - stored_s >= STORED_EVERY_S
            if values and (is_due or len(values) >= STORED_AT_ONCE):
                self._store(values)
                values, stored_s = {}, time.monotonic()
        if values:
            self._store(values)

    def _values(self, recording_id: int, measures: tuple[Measure, ...]) -> Values:
        with self._database.reading() as session:
            recording = recordings.as_recording(recordings.get(session, recording_id))
        accepted = measurable(recording.game, measures)
        if not accepted:
            raise Invalid(f"{recording.game.title} has nothing of what is measured.")
        return self._replays.measure(recording, accepted)

    def _store(self, values: dict[int, Values]) -> None:
        with self._database.writing() as session:
            measured.store(session, values)
