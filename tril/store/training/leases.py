"""A run's worker: claims it, writes to it while the claim holds, ends it.

Every claim raises the run's epoch, and every write carries the epoch of its claim. A worker that
was believed dead and comes back carries an older one: its writes are refused and it stops.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from sqlalchemy import update
from sqlalchemy.engine import CursorResult
from sqlalchemy.orm import Session

from tril.errors import Conflict
from tril.store.changes import note_change
from tril.store.models import RunRow, RunStatus, now
from tril.store.processes import is_fresh
from tril.store.training.runs import CANCELLED_MESSAGE

RELEASED_MESSAGE = "Its worker was stopped; it goes on from the last checkpoint."
LOST_MESSAGE = "Its worker was lost; it goes on from the last checkpoint."


class LeaseLost(Conflict):
    """The run is another worker's now, or nobody's: this claim's work is no longer wanted."""

    def __init__(self, run_id: str) -> None:
        super().__init__(f"The training {run_id} has passed to another worker or was ended.")


@dataclass(frozen=True)
class Lease:
    """The right to work on a run, until somebody claims it again.

    Attributes:
        run_id: The run.
        worker: Name of the worker that has it.
        epoch: Number of the claim; every write carries it.
    """

    run_id: str
    worker: str
    epoch: int


def claim(session: Session, run_id: str, worker: str, versions: Mapping[str, str]) -> Lease | None:
    """Lease a run for a worker.

    Args:
        session: The transaction.
        run_id: The run.
        worker: Name of the worker, which no other living process has.
        versions: What the run will be made with.

    Returns:
        None if the run is over, deleted, or held by another living worker.
    """
    row = session.get(RunRow, run_id, with_for_update=True, populate_existing=True)
    if row is None or row.deleted_at is not None or RunStatus(row.status).is_over:
        return None
    held = row.status != RunStatus.QUEUED
    if held and row.worker != worker and is_fresh(row.heartbeat_at):
        return None
    row.epoch += 1
    note_change(session, "run", run_id)
    if row.status == RunStatus.CANCELLING:
        _end(row, RunStatus.CANCELLED, CANCELLED_MESSAGE)
        return None
    row.status, row.worker, row.versions = RunStatus.RUNNING, worker, dict(versions)
    row.heartbeat_at, row.message = now(), ""
    row.started_at = row.started_at or now()
    return Lease(run_id, worker, row.epoch)


def owned(session: Session, claim: Lease) -> RunRow:
    """Return the run for writing; raises LeaseLost unless the claim still holds."""
    row = session.get(RunRow, claim.run_id, with_for_update=True, populate_existing=True)
    if row is None or row.epoch != claim.epoch or RunStatus(row.status).is_over:
        raise LeaseLost(claim.run_id)
    note_change(session, "run", claim.run_id)
    return row


def is_cancelling(session: Session, claim: Lease) -> bool:
    """Whether the run's worker is asked to stop; raises LeaseLost unless the claim still holds."""
    row = session.get(RunRow, claim.run_id, populate_existing=True)
    if row is None or row.epoch != claim.epoch or RunStatus(row.status).is_over:
        raise LeaseLost(claim.run_id)
    return row.status == RunStatus.CANCELLING


def beat(session: Session, claim: Lease) -> bool:
    """Note that the run's worker lives; returns whether the claim still holds."""
    result = session.execute(
        update(RunRow)
        .where(RunRow.id == claim.run_id, RunRow.epoch == claim.epoch)
        .values(heartbeat_at=now())
    )
    assert isinstance(result, CursorResult)
    return result.rowcount > 0


def report(
    session: Session, claim: Lease, stage: str, done: float, remaining_s: float | None
) -> None:
    """Note how far the run is.

    Args:
        session: The transaction.
        claim: The worker's claim.
        stage: The stage at work.
        done: Share of the stage that is done, 0..1.
        remaining_s: Seconds that the whole run will still take, if that can be told.
    """
    row = owned(session, claim)
    row.stage, row.stage_done, row.remaining_s = stage, min(1.0, max(0.0, done)), remaining_s
    row.heartbeat_at = now()


def finish_stage(session: Session, claim: Lease, stage: str, seconds: float) -> RunRow:
    """Note, in the transaction that writes a stage's results, that the stage is finished."""
    row = owned(session, claim)
    row.finished_stages = {**row.finished_stages, stage: round(seconds, 3)}
    row.stage, row.stage_done = stage, 1.0
    return row


def end(session: Session, claim: Lease, status: RunStatus, message: str = "") -> None:
    """End the run: done, stopped, failed or cancelled, with a message for people."""
    if not status.is_over:
        raise ValueError(f"Expected a status in which a run is over, got {status}.")
    row = owned(session, claim)
    if row.status == RunStatus.CANCELLING and status is not RunStatus.DONE:
        status, message = RunStatus.CANCELLED, CANCELLED_MESSAGE
    _end(row, status, message)


def _end(row: RunRow, status: RunStatus, message: str) -> None:
    row.status, row.message = status, message
    row.finished_at, row.remaining_s = now(), None


def release(session: Session, claim: Lease) -> None:
    """Give the run back to the queue in good order, e.g. because the worker is being stopped."""
    _give_back(owned(session, claim), RELEASED_MESSAGE)


def take_away(session: Session, run_id: str, epoch: int) -> bool:
    """Take a run away from a worker that is gone, if it is still that claim's.

    Returns:
        Whether the run now waits for another worker.
    """
    row = session.get(RunRow, run_id, with_for_update=True, populate_existing=True)
    if row is None or row.epoch != epoch:
        return False
    if row.status not in {RunStatus.RUNNING, RunStatus.CANCELLING}:
        return False
    _give_back(row, LOST_MESSAGE)
    note_change(session, "run", run_id)
    return row.status == RunStatus.QUEUED


def _give_back(row: RunRow, message: str) -> None:
    row.epoch += 1
    if row.status == RunStatus.CANCELLING:
        _end(row, RunStatus.CANCELLED, CANCELLED_MESSAGE)
        return
    row.status, row.message, row.remaining_s = RunStatus.QUEUED, message, None


def fail_undeliverable(session: Session, run_id: str, message: str) -> None:
    """Fail a run that the queue has given up on, unless it is over."""
    row = session.get(RunRow, run_id, with_for_update=True, populate_existing=True)
    if row is None or RunStatus(row.status).is_over:
        return
    row.epoch += 1
    _end(row, RunStatus.FAILED, message)
    note_change(session, "run", run_id)
