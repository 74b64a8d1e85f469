"""Brings runs to workers and repairs what a crash left half done."""

from __future__ import annotations

import logging
import threading
import time
from dataclasses import dataclass
from typing import Any

from dbos import WorkflowStatus, error
from sqlalchemy.exc import SQLAlchemyError

from tril.errors import Unavailable
from tril.jobs.queue import QUEUES, VERSION, WORKFLOW, open_client
from tril.settings import Settings
from tril.store import processes
from tril.store.database import Database
from tril.store.models import RunDevice, RunRow, RunStatus
from tril.store.training import leases, runs

log = logging.getLogger(__name__)

LOST_AFTER_S = 30.0
"""A lease is revoked once its run did not change for this long, by the watcher's own clock."""

MAX_PATIENCE_DOUBLINGS = 4
"""Every two leases of a run double the time, since they tell of a slow machine."""

RECONCILE_EVERY_S = 5.0
MAX_WATCHED_S = 2 * RECONCILE_EVERY_S
"""What one look counts for at most: a watcher that was suspended itself has watched nothing."""

ACTIVE = frozenset({"ENQUEUED", "DELAYED", "PENDING"})
GIVEN_UP = "MAX_RECOVERY_ATTEMPTS_EXCEEDED"
GIVEN_UP_MESSAGE = (
    "The worker died each time it took this training up, so it is not tried any more. It may have "
    "run out of memory. Resume to try again."
)


@dataclass(frozen=True)
class _Watch:
    """A run and its job as they are, for how long they were seen so, and when last: seconds."""

    state: tuple[Any, ...]
    unchanged_s: float
    seen_at_s: float


class Jobs:
    """Enqueues, cancels and resumes runs.

    Every method changes the run's row first and then the queue. A crash in between leaves a row
    whose job is missing or over, or a job whose row is over; ``reconcile`` makes a new job for the
    former, and a worker that gets the latter finds nothing to do.

    Args:
        database: The application's database.
        settings: Says where the queue is.
        lost_after_s: Seconds without a change after which a worker's lease is revoked, unless its
            process is known to live. The time is measured by watching heartbeats change, so clocks
            need not agree and a machine that slept is not taken for dead.
    """

    def __init__(
        self, database: Database, settings: Settings, lost_after_s: float = LOST_AFTER_S
    ) -> None:
        self._database = database
        self._client = open_client(settings)
        self._lost_after_s = lost_after_s
        self._watched: dict[str, _Watch] = {}
        self._closing = threading.Event()
        self._reconciling: threading.Thread | None = None

    def enqueue(self, run_id: str) -> None:
        """Enqueue a queued run; if the queue can't be reached, ``reconcile`` does it later."""
        try:
            with self._database.reading() as session:
                device = RunDevice(runs.get(session, run_id).device)
            self._deliver(run_id, device)
        except (SQLAlchemyError, error.DBOSException, Unavailable) as problem:
            log.warning("Run %s could not be enqueued yet: %s", run_id, problem)

    def cancel(self, run_id: str, player_id: int | None = None) -> None:
        """Cancel a run; a worker that has it stops within seconds.

        Raises:
            NotFound: No such run.
            Conflict: The run is over already.
        """
        with self._database.writing() as session:
            row = runs.request_cancel(session, run_id, player_id)
        if row.status == RunStatus.CANCELLED:
            try:
                self._client.cancel_workflow(run_id)
            except (SQLAlchemyError, error.DBOSException) as problem:
                log.warning("The job of cancelled run %s stays in the queue: %s", run_id, problem)

    def resume(self, run_id: str) -> None:
        """Let a cancelled, stopped or failed run go on from its last checkpoint.

        Raises:
            NotFound: No such run.
            Conflict: The run is done or not over.
        """
        with self._database.writing() as session:
            runs.queue_again(session, run_id)
        self.enqueue(run_id)

    def reconcile(self) -> None:
        """Make the queue agree with the rows: no run waits without a job, no job without a worker.

        Call it at start and then every few seconds; between calls the same ``Jobs`` notices
        workers that are gone by watching their runs.
        """
        with self._database.reading() as session:
            candidates = [row.id for row in runs.unfinished(session)]
        # The queue is read before the rows: a worker ends its row first, so a job that was over
        # before a row was read as unfinished really is a job that ended without ending its row.
        jobs = self._jobs(candidates)
        with self._database.reading() as session:
            rows = [row for row in runs.unfinished(session) if row.id in set(candidates)]
        self._watched = {row.id: self._watch(row, jobs.get(row.id)) for row in rows}
        for row in rows:
            try:
                self._repair(row, jobs.get(row.id))
            except error.DBOSException as problem:
                # Mostly another process that repaired it at the same moment; the next call tells.
                log.warning("The job of run %s could not be repaired yet: %s", row.id, problem)
            except Exception:
                log.exception("The job of run %s could not be repaired.", row.id)

    def start_reconciling(self, every_s: float = RECONCILE_EVERY_S) -> None:
        """Reconcile now and then every few seconds, in a thread that ``close`` ends."""
        self._reconciling = threading.Thread(
            target=self._reconcile_until_closed, args=(every_s,), name="reconcile", daemon=True
        )
        self._reconciling.start()

    def _reconcile_until_closed(self, every_s: float) -> None:
        while True:
            try:
                self.reconcile()
            except Exception:
                log.exception("The queue could not be compared with the runs.")
            if self._closing.wait(every_s):
                return

    def close(self) -> None:
        """Close the connection to the queue."""
        self._closing.set()
        if self._reconciling is not None:
            self._reconciling.join()
        self._client.destroy()

    def _watch(self, row: RunRow, job: WorkflowStatus | None) -> _Watch:
        state = (row.status, row.epoch, row.heartbeat_at) + (
            (job.status, job.executor_id, job.updated_at) if job else ()
        )
        now_s, earlier = time.monotonic(), self._watched.get(row.id)
        if earlier is None or earlier.state != state:
            return _Watch(state, 0.0, now_s)
        watched_s = min(now_s - earlier.seen_at_s, MAX_WATCHED_S)
        return _Watch(state, earlier.unchanged_s + watched_s, now_s)

    def _is_lost(self, row: RunRow, worker: str | None) -> bool:
        """Whether nothing was heard of a run for long, and its worker is not known to live."""
        if self._watched[row.id].unchanged_s < self._patience_s(row):
            return False
        with self._database.reading() as session:
            return worker is None or not processes.is_at_work(session, worker, row.id)

    def _patience_s(self, row: RunRow) -> float:
        doublings = min((row.epoch - 1) // 2, MAX_PATIENCE_DOUBLINGS)
        return float(self._lost_after_s * 2 ** max(0, doublings))

    def _repair(self, row: RunRow, job: WorkflowStatus | None) -> None:
        if row.status == RunStatus.QUEUED:
            if job is None or job.status not in ACTIVE:
                log.info("Run %s waits without a job; it gets one.", row.id)
                self._deliver(row.id, RunDevice(row.device))
            elif job.status == "PENDING" and self._is_lost(row, job.executor_id):
                self._redeliver(row, job)
        elif job is not None and job.status == GIVEN_UP:
            with self._database.writing() as session:
                leases.fail_undeliverable(session, row.id, GIVEN_UP_MESSAGE)
        elif self._is_lost(row, row.worker):
            with self._database.writing() as session:
                is_queued = leases.revoke(session, row.id, row.epoch)
            if is_queued:
                self._redeliver(row, job)

    def _redeliver(self, row: RunRow, job: WorkflowStatus | None) -> None:
        log.warning(
            "Nothing was heard of run %s (%s) for %.0f s; another worker may go on with it.",
            row.id,
            job.executor_id if job else "no worker",
            self._patience_s(row),
        )
        if job is not None and job.status == "PENDING":
            self._client.resume_workflow(row.id, queue_name=QUEUES[RunDevice(row.device)])
        else:
            self._deliver(row.id, RunDevice(row.device))

    def _deliver(self, run_id: str, device: RunDevice) -> None:
        job = self._jobs([run_id]).get(run_id)
        if job is None:
            self._client.enqueue(
                {
                    "workflow_name": WORKFLOW,
                    "queue_name": QUEUES[device],
                    "workflow_id": run_id,
                    "app_version": VERSION,
                },
                run_id,
            )
        elif job.status not in ACTIVE:
            try:
                self._client.rewind_workflow(run_id, queue_name=QUEUES[device])
            except error.DBOSException:
                again = self._jobs([run_id]).get(run_id)
                if again is None or again.status not in ACTIVE:
                    raise

    def _jobs(self, run_ids: list[str]) -> dict[str, WorkflowStatus]:
        if not run_ids:
            return {}
        workflows = self._client.list_workflows(
            workflow_ids=run_ids, load_input=False, load_output=False
        )
        return {job.workflow_id: job for job in workflows}
