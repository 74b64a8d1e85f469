"""The worker: takes runs from the queue, one at a time, and trains."""

from __future__ import annotations

import fcntl
import logging
import os
import secrets
import signal
import threading
from pathlib import Path
from types import TracebackType
from typing import Any, Self, TextIO

from dbos import DBOS

from trainer.runtime.logs import set_up_logging
from trainer.runtime.pipeline import Pipeline
from trainer.runtime.throttle import lower_priority
from tril.errors import Unavailable
from tril.files.artifact_store import write_whole
from tril.heartbeat import Heartbeat
from tril.jobs import APPLICATION, QUEUE, VERSION, WORKFLOW, Jobs, prepare_queue
from tril.jobs.delivery import LOST_AFTER_S
from tril.jobs.queue import serializer
from tril.settings import Settings
from tril.store.database import Database, create_database
from tril.store.schema import check_schema

log = logging.getLogger(__name__)

STOP_TIMEOUT_S = 8
MOST_DELIVERIES = 50
"""Times that the queue brings one run anew after its worker died before it is given up."""

MOST_WORKERS = 64


def run_worker(settings: Settings, lost_after_s: float = LOST_AFTER_S) -> None:
    """Run a worker until it is told to stop (SIGTERM or Ctrl-C).

    Args:
        settings: Settings of the process.
        lost_after_s: Seconds without a sign of life after which another worker is given up.

    Raises:
        Unavailable: The databases are not of this version.
    """
    set_up_logging()
    lower_priority()
    stopping = threading.Event()
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: stopping.set())
    database = create_database(settings.application_url)
    try:
        check_schema(database)
        with WorkerName(settings.data) as name:
            Worker(settings, database, name.value, stopping).work(lost_after_s)
    finally:
        database.close()


class Worker:
    """One worker process: pipeline, heartbeat, queue.

    Args:
        settings: Settings of the process.
        database: The application's database.
        name: Name of the worker, which no other living process has.
        stopping: Set to end the worker.
    """

    def __init__(
        self, settings: Settings, database: Database, name: str, stopping: threading.Event
    ) -> None:
        self._settings = settings
        self._database = database
        self._name = name
        self._stopping = stopping
        self._pipeline = Pipeline(database, settings, name, stopping)

    def work(self, lost_after_s: float = LOST_AFTER_S) -> None:
        """Take runs from the queue until told to stop; the run at work goes back to the queue."""
        prepare_queue(self._settings)
        self._pipeline.sweep()
        jobs = Jobs(self._database, self._settings, lost_after_s)
        heartbeat = Heartbeat(
            self._database, self._name, "worker", self._details, self._pipeline.beat
        )
        try:
            with heartbeat:
                self._take_from_queue()
                log.info("Worker %s waits for runs.", self._name)
                jobs.start_reconciling()
                self._stopping.wait()
                log.info("Worker %s is stopping.", self._name)
                DBOS.destroy(workflow_completion_timeout_sec=STOP_TIMEOUT_S)
        finally:
            jobs.close()

    def _take_from_queue(self) -> None:
        DBOS(
            config={
                "name": APPLICATION,
                "system_database_url": self._settings.queue_url,
                "executor_id": self._name,
                "application_version": VERSION,
                "serializer": serializer(),
                "log_level": "WARNING",
            }
        )
        pipeline = self._pipeline

        @DBOS.step(name="stage")
        def perform(run_id: str, stage: str) -> str:
            return pipeline.perform(run_id, stage)

        @DBOS.workflow(name=WORKFLOW, max_recovery_attempts=MOST_DELIVERIES)
        def train(run_id: str) -> str:
            return pipeline.train(run_id, perform)

        DBOS.listen_queues([QUEUE])
        DBOS.launch()

    def _details(self) -> dict[str, Any]:
        return {"runs": self._pipeline.run_ids, "pid": os.getpid()}


class WorkerName:
    """A name that no other living worker has, and that the next worker gets when this one is gone.

    Workers of one data folder are numbered; each holds a lock on its number's file as long as its
    process lives, however it ends. A number of the data folder's own tells its workers from those
    of other machines. So a worker that was killed comes back under its name, and its runs with it.

    Args:
        data: The data folder.
    """

    def __init__(self, data: Path) -> None:
        self._folder = data / "workers"
        self._file: TextIO | None = None
        self.value = ""

    def __enter__(self) -> Self:
        self._folder.mkdir(parents=True, exist_ok=True)
        for number in range(MOST_WORKERS):
            file = (self._folder / f"worker-{number}.lock").open("a")
            try:
                # Not flock: its lock would pass on to processes that inherit the descriptor.
                fcntl.lockf(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except OSError:
                file.close()
                continue
            self._file = file
            self.value = f"worker-{number}-{self._installation()}"
            return self
        raise Unavailable(f"{MOST_WORKERS} workers run in this data folder already.")

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if self._file is not None:
            self._file.close()

    def _installation(self) -> str:
        path = self._folder / "installation"
        with (self._folder / "installation.lock").open("a") as lock:
            fcntl.lockf(lock, fcntl.LOCK_EX)
            if not path.exists():
                write_whole(path, secrets.token_hex(4).encode())
            return path.read_text()
