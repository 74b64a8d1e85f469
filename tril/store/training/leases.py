"""The lease of a run to a worker: acquired, written under, given back, revoked.

Every lease raises the run's epoch, and every write carries the epoch of its lease. A worker that
was taken for dead and comes back carries an older one: its writes are refused and it stops.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass

from sqlalchemy import update
from sqlalchemy.engine import CursorResult
from sqlalchemy.orm import Session

from tril.errors import Conflict
from tril.store import processes
from tril.store.changes import note_change
from tril.store.database import database_now
from tril.store.models import RunRow, RunStatus
from tril.store.training import runs
from tril.store.training.runs import CANCELLED_MESSAGE

RELEASED_MESSAGE = "Its worker was stopped; it goes on from the last checkpoint."
LOST_MESSAGE = "Its worker was lost; it goes on from the last checkpoint."


class LeaseLost(Conflict):
    """The run is another worker's now, or nobody's."""

    def __init__(self, run_id: str) -> None:
        super().__init__(f"The training {run_id} has passed to another worker or was ended.")


@dataclass(frozen=True)
class Lease:
    """The right to work on a run, until it is leased again.

    Attributes:
        run_id: The run.
        worker: Name of the worker that has it.
        epoch: Number of the lease; every write carries it.
    """

    run_id: str
    worker: str
    epoch: int


def acquire(session: Session, run_id: str, worker: str) -> Lease | None:
    """Lease a run to a worker.

    Args:
        session: The transaction.
        run_id: The run.
        worker: Name of the worker, which no other living process has.

    Returns:
        None if the run is over, deleted, or leased to another living worker.
    """
    row = _locked(session, run_id)
    if row is None or row.deleted_at is not None or RunStatus(row.status).is_over:
        return None
    if row.worker != worker and (
        runs.has_worker(session, row)
        or (RunStatus(row.status).is_leased and processes.is_at_work(session, row.worker, run_id))
    ):
        return None
    row.epoch += 1
    note_change(session, "run", run_id)
    if row.status == RunStatus.CANCELLING:
        _end(session, row, RunStatus.CANCELLED, CANCELLED_MESSAGE)
        return None
    row.status, row.worker = RunStatus.RUNNING, worker
    row.heartbeat_at, row.message = database_now(session), ""
    row.started_at = row.started_at or row.heartbeat_at
    return Lease(run_id, worker, row.epoch)


def owned(session: Session, lease: Lease) -> RunRow:
    """Return the run for writing; raises LeaseLost unless the lease still holds."""
    row = _checked(_locked(session, lease.run_id), lease)
    note_change(session, "run", lease.run_id)
    return row


def keep_versions(session: Session, lease: Lease, versions: Mapping[str, str]) -> None:
    """Keep what the run is made with; raises LeaseLost unless the lease still holds."""
    owned(session, lease).versions = dict(versions)


def is_cancelling(session: Session, lease: Lease) -> bool:
    """Whether the run's worker is asked to stop; raises LeaseLost unless the lease still holds."""
    row = session.get(RunRow, lease.run_id, populate_existing=True)
    return _checked(row, lease).status == RunStatus.CANCELLING


def _locked(session: Session, run_id: str) -> RunRow | None:
    return session.get(RunRow, run_id, with_for_update=True, populate_existing=True)


def _checked(row: RunRow | None, lease: Lease) -> RunRow:
    if row is None or row.epoch != lease.epoch or RunStatus(row.status).is_over:
        raise LeaseLost(lease.run_id)
    return row


def beat(session: Session, lease: Lease) -> bool:
    """Write the heartbeat of the run's worker; returns whether the lease still holds."""
    result = session.execute(
        update(RunRow)
        .where(RunRow.id == lease.run_id, RunRow.epoch == lease.epoch)
        .values(heartbeat_at=database_now(session))
    )
    assert isinstance(result, CursorResult)
    return result.rowcount > 0


def forget_remaining(session: Session, lease: Lease) -> None:
    """Take back when the run will be over, because its stage has been silent for long."""
    result = session.execute(
        update(RunRow)
        .where(
            RunRow.id == lease.run_id,
            RunRow.epoch == lease.epoch,
            RunRow.remaining_s.is_not(None),
        )
        .values(remaining_s=None)
    )
    assert isinstance(result, CursorResult)
    if result.rowcount:
        note_change(session, "run", lease.run_id)


def report(
    session: Session, lease: Lease, stage: str, done: float, remaining_s: float | None
) -> None:
    """Write how far the run is.

    Args:
        session: The transaction.
        lease: The worker's lease.
        stage: The stage at work.
        done: Share of the stage that is done, 0..1.
        remaining_s: Estimated seconds to the end of the whole run; None if unknown.
    """
    row = owned(session, lease)
    row.stage, row.stage_done, row.remaining_s = stage, min(1.0, max(0.0, done)), remaining_s
    row.heartbeat_at = database_now(session)


def finish_stage(session: Session, lease: Lease, stage: str, seconds: float) -> RunRow:
    """Write, in the transaction that writes a stage's results, that the stage is finished."""
    row = owned(session, lease)
    row.finished_stages = {**row.finished_stages, stage: round(seconds, 3)}
    row.stage, row.stage_done = stage, 1.0
    return row


def reopen_stages(session: Session, lease: Lease, stages: Collection[str]) -> None:
    """Write that stages are not finished after all, because what they made was damaged."""
    row = owned(session, lease)
    row.finished_stages = {k: v for k, v in row.finished_stages.items() if k not in stages}


def end(session: Session, lease: Lease, status: RunStatus, message: str = "") -> None:
    """End the run: done, stopped, failed or cancelled, with a message for people."""
    if not status.is_over:
        raise ValueError(f"Expected a status in which a run is over, got {status}.")
    row = owned(session, lease)
    if row.status == RunStatus.CANCELLING and status is not RunStatus.DONE:
        status, message = RunStatus.CANCELLED, CANCELLED_MESSAGE
    _end(session, row, status, message)


def release(session: Session, lease: Lease, message: str = RELEASED_MESSAGE) -> None:
    """Give the run back to the queue in good order, e.g. because the worker is being stopped."""
    _give_back(session, owned(session, lease), message)


def note_waiting_reason(session: Session, run_id: str, message: str) -> None:
    """Say why a run in the queue is not taken up, unless that is said already."""
    row = _locked(session, run_id)
    if row is not None and row.status == RunStatus.QUEUED and row.message != message:
        row.message = message
        note_change(session, "run", run_id)


def revoke(session: Session, run_id: str, epoch: int) -> bool:
    """Give a run back to the queue whose worker is gone, if the lease is still of that epoch.

    A worker that is known to live keeps its run, however long it has been silent.

    Returns:
        Whether the run is queued again; one that was being cancelled is over instead.
    """
    row = _locked(session, run_id)
    if row is None or row.epoch != epoch or not RunStatus(row.status).is_leased:
        return False
    if processes.is_at_work(session, row.worker, run_id):
        return False
    _give_back(session, row, LOST_MESSAGE)
    note_change(session, "run", run_id)
    return row.status == RunStatus.QUEUED


def fail_undeliverable(session: Session, run_id: str, message: str) -> None:
    """Fail a run that the queue has given up on, unless it is over."""
    row = _locked(session, run_id)
    if row is None or RunStatus(row.status).is_over:
        return
    row.epoch += 1
    _end(session, row, RunStatus.FAILED, message)
    note_change(session, "run", run_id)


def _give_back(session: Session, row: RunRow, message: str) -> None:
    row.epoch += 1
    if row.status == RunStatus.CANCELLING:
        _end(session, row, RunStatus.CANCELLED, CANCELLED_MESSAGE)
    else:
        row.status, row.message, row.remaining_s = RunStatus.QUEUED, message, None


def _end(session: Session, row: RunRow, status: RunStatus, message: str) -> None:
    row.status, row.message = status, message
    row.finished_at, row.remaining_s = database_now(session), None
