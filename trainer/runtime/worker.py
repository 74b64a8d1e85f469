"""The worker: takes runs from the queue, one at a time, and trains."""

from __future__ import annotations

import errno
import fcntl
import logging
import os
import secrets
import signal
import socket
import threading
from collections.abc import Collection, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import NoReturn, TextIO

import torch
from dbos import DBOS
from sqlalchemy.exc import SQLAlchemyError

from trainer.nn.devices import learning_device
from trainer.runtime.logs import set_up_logging
from trainer.runtime.pipeline import Pipeline
from trainer.runtime.priority import lower_priority
from tril.cores import core_count
from tril.errors import Invalid, Unavailable
from tril.files.artifact_store import write_whole
from tril.heartbeat import Heartbeat
from tril.jobs import QUEUES, WORKFLOW, Jobs, executor_config, prepare_queue
from tril.jobs.delivery import LOST_AFTER_S
from tril.settings import Settings
from tril.store.database import Database, create_database
from tril.store.models import RunDevice
from tril.store.schema import check_schema
from tril.store.training import runs

log = logging.getLogger(__name__)

STOP_TIMEOUT_S = 8
MAX_DELIVERIES = 50
"""Times that the queue delivers one run again after its worker died before it is given up."""

MAX_WORKERS = 64

EMPTY_POLL_S = 2.0

WRITE_PATIENCE_S = 600.0
"""How long a worker waits for other writers: on an overloaded machine each may take long."""

SWEEP_EVERY_S = 60.0
"""A run that passed to another machine and is done there leaves its scratch folder on this one."""


class Superseded(BaseException):
    """Ends an execution whose job is another's by now; its outcome is not recorded."""


def run_worker(
    settings: Settings, lost_after_s: float = LOST_AFTER_S, *, until_empty: bool = False
) -> None:
    """Run a worker until it is told to stop (SIGTERM or Ctrl-C).

    Args:
        settings: Settings of the process.
        lost_after_s: Seconds without a change after which another worker's lease is revoked.
        until_empty: Whether it also stops once no run waits or is at work, here or elsewhere.

    Raises:
        Unavailable: The databases are not of this version.
    """
    set_up_logging()
    lower_priority(settings.learning_niceness)
    stopping = threading.Event()
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: stopping.set())
    database = create_database(settings.application_url, WRITE_PATIENCE_S)
    try:
        check_schema(database)
        with worker_name(settings.data) as name:
            _work(settings, database, name, stopping, lost_after_s, until_empty)
    finally:
        database.close()


def _work(
    settings: Settings,
    database: Database,
    name: str,
    stopping: threading.Event,
    lost_after_s: float,
    until_empty: bool,
) -> None:
    """Take runs from the queue until told to stop; the run at work goes back to the queue."""
    prepare_queue(settings)
    gpu = _gpu_name(settings)
    devices = list(RunDevice) if gpu else [RunDevice.ANY]
    pipeline = Pipeline(database, settings, name, stopping)
    pipeline.sweep()
    jobs = Jobs(database, settings, lost_after_s)
    try:
        with Heartbeat(
            database,
            name,
            "worker",
            lambda: {
                "runs": pipeline.run_ids,
                "pid": os.getpid(),
                "host": socket.gethostname(),
                "cores": core_count(),
                "gpu": gpu,
            },
            pipeline.beat,
        ):
            _take_from_queue(settings, name, pipeline, devices)
            log.info("Worker %s waits for runs.", name)
            jobs.start_reconciling()
            if until_empty:
                _wait_until_empty(database, stopping, devices)
            else:
                sweep_periodically(stopping, pipeline)
            log.info("Worker %s is stopping.", name)
            DBOS.destroy(workflow_completion_timeout_sec=STOP_TIMEOUT_S)
    finally:
        jobs.close()


def _gpu_name(settings: Settings) -> str | None:
    """Return the name of the GPU that this worker learns on; None if it learns on the CPU."""
    try:
        device = learning_device(settings.learning_device)
    except Invalid as problem:
        # Its runs will fail and say so.
        log.warning("%s", problem)
        return None
    return torch.cuda.get_device_name(device) if device.type == "cuda" else None


def _wait_until_empty(
    database: Database, stopping: threading.Event, devices: Collection[str]
) -> None:
    """Wait until no run for these devices waits or is at work.

    One that another worker has may come back.
    """
    while not stopping.wait(EMPTY_POLL_S):
        try:
            with database.reading() as session:
                if not any(run.device in devices for run in runs.unfinished(session)):
                    log.info("No run is left.")
                    return
        except SQLAlchemyError:
            log.warning("The runs could not be read; they are read again.", exc_info=True)


def sweep_periodically(
    stopping: threading.Event, pipeline: Pipeline, every_s: float = SWEEP_EVERY_S
) -> None:
    """Remove unneeded scratch folders periodically until the worker stops."""
    while not stopping.wait(every_s):
        try:
            pipeline.sweep()
        except SQLAlchemyError as problem:
            log.warning("Old scratch folders could not be looked for: %s", problem)


def _take_from_queue(
    settings: Settings, name: str, pipeline: Pipeline, devices: Collection[RunDevice]
) -> None:
    dbos = DBOS(config=executor_config(settings, name))
    # DBOS counts what a worker has at work for each queue separately; this one has one run of all.
    active = dbos._active_workflows_set
    active.count_for_queue = lambda queue_name: len(active.activeList())  # type: ignore[method-assign]

    @DBOS.step(name="stage")
    def run_stage(run_id: str, stage: str) -> str:
        return pipeline.run_stage(run_id, stage)

    @DBOS.workflow(name=WORKFLOW, max_recovery_attempts=MAX_DELIVERIES)
    def train(run_id: str) -> str:
        return pipeline.train(run_id, run_stage)

    DBOS.listen_queues([QUEUES[device] for device in devices])
    DBOS.launch()
    # An execution that lost its job would poll for the outcome of the one that has it, for hours.
    dbos._sys_db.await_workflow_result = _end_superseded  # type: ignore[assignment, method-assign]


def _end_superseded(run_id: str, **_options: object) -> NoReturn:
    log.info("Run %s: its job was delivered again; this execution ends.", run_id)
    raise Superseded


@contextmanager
def worker_name(data: Path) -> Iterator[str]:
    """Give a name that no other living worker has, and that is free again once this one is gone.

    Workers of one data folder are numbered; each holds a lock on its number's file for as long as
    its process lives, however it ends. An id drawn once per data folder tells its workers from
    those of other machines. So a worker that was killed comes back under its name, and its run
    with it.

    Args:
        data: The data folder.

    Raises:
        Unavailable: All names are taken.
    """
    folder = data / "workers"
    folder.mkdir(parents=True, exist_ok=True)
    number, lock = _first_free(folder)
    with lock:
        yield f"worker-{number}-{_installation(folder)}"


def _first_free(folder: Path) -> tuple[int, TextIO]:
    for number in range(MAX_WORKERS):
        lock = (folder / f"worker-{number}.lock").open("a")
        try:
            # Not flock: its lock would pass on to processes that inherit the descriptor.
            fcntl.lockf(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as problem:
            lock.close()
            if problem.errno not in {errno.EAGAIN, errno.EACCES}:
                raise
        else:
            return number, lock
    raise Unavailable(f"{MAX_WORKERS} workers run in this data folder already.")


def _installation(folder: Path) -> str:
    path = folder / "installation"
    with (folder / "installation.lock").open("a") as lock:
        fcntl.lockf(lock, fcntl.LOCK_EX)
        if not path.exists():
            write_whole(path, secrets.token_hex(4).encode())
        return path.read_text()
