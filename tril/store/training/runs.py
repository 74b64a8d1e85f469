"""Runs as people see them: listed, cancelled, resumed, deleted."""

from __future__ import annotations

from collections.abc import Iterable
from datetime import datetime

from sqlalchemy import ColumnElement, func, select
from sqlalchemy.orm import Session

from tril.errors import Conflict, NotFound
from tril.recipes import former_method, recipe_from_dict
from tril.store import audit, processes
from tril.store.changes import note_change
from tril.store.database import database_now
from tril.store.models import NOT_OVER, RunRow, RunStatus, now

MAX_NAME_LENGTH = 80
MAX_NOTES_LENGTH = 4000

CANCELLED_MESSAGE = "Cancelled. It can be resumed and goes on from its last checkpoint."
CANCELLED_WAITING_MESSAGE = "Cancelled before it began. Resume it to start it."


def count_queued(session: Session, *further: ColumnElement[bool]) -> int:
    """Return the number of runs that wait in the queue and meet further conditions."""
    queued = (RunRow.status == RunStatus.QUEUED, RunRow.deleted_at.is_(None), *further)
    return session.scalar(select(func.count()).select_from(RunRow).where(*queued)) or 0


def count_of_player(session: Session, player_id: int) -> int:
    """Return the number of a player's runs, including deleted ones."""
    query = select(func.count()).select_from(RunRow).where(RunRow.player_id == player_id)
    return session.scalar(query) or 0


def get(session: Session, run_id: str, *, for_update: bool = False) -> RunRow:
    """Return a run, locked if asked for; raises NotFound if there is none or it was deleted."""
    row = session.get(
        RunRow, run_id, with_for_update=for_update or None, populate_existing=for_update
    )
    if row is None or row.deleted_at is not None:
        raise NotFound("There is no such training (any more).")
    return row


def get_done(session: Session, run_id: str) -> RunRow:
    """Return a run that is done; raises Conflict if it is not, besides what ``get`` raises."""
    row = get(session, run_id)
    if row.status != RunStatus.DONE:
        raise Conflict(
            f"This training is {row.status}. It can be taken away once it is done, with everything"
            " that belongs to it."
        )
    return row


def lineage(session: Session, row: RunRow) -> list[RunRow]:
    """Return a run, the run that it continues, and so on; deleted ones too."""
    rows = [row]
    while (parent := rows[-1].parent_run_id) is not None:
        rows.append(session.get_one(RunRow, parent))
    return rows


def listing(
    session: Session,
    behaviour_id: int | None = None,
    *,
    active_only: bool = False,
    before: str | None = None,
    limit: int | None = None,
) -> list[RunRow]:
    """Return the runs, newest first.

    Args:
        session: The transaction.
        behaviour_id: Only those of this behaviour.
        active_only: Only those that are not over.
        before: Only those that follow this run in the list, even if it was deleted since.
        limit: Most runs that are returned.

    Raises:
        NotFound: There has never been the run of ``before``.
    """
    query = select(RunRow).where(RunRow.deleted_at.is_(None))
    if behaviour_id is not None:
        query = query.where(RunRow.behaviour_id == behaviour_id)
    if active_only:
        query = query.where(RunRow.status.in_(NOT_OVER))
    if before is not None:
        last = session.get(RunRow, before)
        if last is None:
            raise NotFound("There is no such training.")
        is_same_age = RunRow.created_at == last.created_at
        query = query.where(
            (RunRow.created_at < last.created_at) | (is_same_age & (RunRow.id > last.id))
        )
    return list(session.scalars(query.order_by(RunRow.created_at.desc(), RunRow.id).limit(limit)))


def newest_done(session: Session, behaviour_id: int) -> RunRow | None:
    """Return a behaviour's newest finished run; None if it has none."""
    rows = listing(session, behaviour_id)
    return next((row for row in rows if row.status == RunStatus.DONE), None)


def unfinished(session: Session) -> list[RunRow]:
    """Return the unfinished runs, oldest first."""
    query = select(RunRow).where(RunRow.deleted_at.is_(None), RunRow.status.in_(NOT_OVER))
    return list(session.scalars(query.order_by(RunRow.created_at, RunRow.id)))


def queue_position(session: Session, row: RunRow) -> int | None:
    """Return a run's place among the waiting ones, 1 for the next; None if it doesn't wait.

    The queue hands out the oldest run first, also if it was cancelled and resumed in between.
    """
    if row.status != RunStatus.QUEUED:
        return None
    is_older = (RunRow.created_at < row.created_at) | (
        (RunRow.created_at == row.created_at) & (RunRow.id < row.id)
    )
    return count_queued(session, is_older) + 1


def not_resumable(session: Session, run_ids: Iterable[str]) -> list[str]:
    """Return those of these runs that can't be resumed: done or deleted ones."""
    query = select(RunRow.id).where(
        RunRow.id.in_(list(run_ids)),
        (RunRow.status == RunStatus.DONE) | RunRow.deleted_at.is_not(None),
    )
    return list(session.scalars(query))


def latest_done(
    session: Session, recipe_name: str, before: datetime | None = None
) -> RunRow | None:
    """Return the newest finished run of a recipe, of those that were trained here.

    Args:
        session: The transaction.
        recipe_name: Name of the recipe.
        before: Only runs that finished before this time.
    """
    query = select(RunRow).where(
        RunRow.recipe_name == recipe_name,
        RunRow.status == RunStatus.DONE,
        # No worker has ever had one that was imported.
        RunRow.epoch > 0,
    )
    if before is not None:
        query = query.where(RunRow.finished_at < before)
    return session.scalar(query.order_by(RunRow.finished_at.desc()).limit(1))


def has_worker(session: Session, row: RunRow) -> bool:
    """Whether a living worker has the run, as far as can be told."""
    return (
        RunStatus(row.status).is_leased
        and processes.is_fresh(session, row.heartbeat_at)
        and not processes.has_ended(session, row.worker)
    )


def request_cancel(session: Session, run_id: str, player_id: int | None = None) -> RunRow:
    """Cancel a run: at once if no living worker has it, else the worker is asked to stop.

    Raises:
        Conflict: The run is over already.
    """
    row = get(session, run_id, for_update=True)
    status = RunStatus(row.status)
    if status is RunStatus.CANCELLED:
        return row
    if status.is_over:
        raise Conflict(f"This training is already over ({status}); nothing is left to cancel.")
    if has_worker(session, row):
        row.status = RunStatus.CANCELLING
    else:
        row.status = RunStatus.CANCELLED
        row.message = CANCELLED_MESSAGE if row.started_at else CANCELLED_WAITING_MESSAGE
        row.finished_at, row.remaining_s = database_now(session), None
        row.epoch += 1
    audit.note(session, audit.Action.RUN_CANCELLED, player_id, f"run {run_id}")
    note_change(session, "run", run_id)
    return row


def queue_again(session: Session, run_id: str) -> RunRow:
    """Queue a cancelled, stopped or failed run again; one that the check stopped goes on anyway.

    Raises:
        Conflict: The run is done, or not over yet, or this version cannot train by its recipe.
    """
    row = get(session, run_id, for_update=True)
    status = RunStatus(row.status)
    if status is RunStatus.DONE:
        raise Conflict("This run is done. Start a new one to train again.")
    if not status.is_over:
        raise Conflict(f"This run is not over yet ({status}); there is nothing to resume.")
    recipe = recipe_from_dict(row.recipe)
    if (method := former_method(recipe)) is not None:
        raise Conflict(
            f"This run was trained by the method {method!r}, which this version of Tril does not"
            " have any more. Start a new run with one of today's recipes."
        )
    row.go_on_anyway = row.go_on_anyway or status is RunStatus.STOPPED
    row.status, row.message = RunStatus.QUEUED, ""
    row.finished_at, row.remaining_s = None, None
    note_change(session, "run", run_id)
    return row


def describe(
    session: Session,
    run_id: str,
    name: str | None = None,
    notes: str | None = None,
    player_id: int | None = None,
) -> RunRow:
    """Change a run's name or notes; None leaves them as they are, "" removes them.

    Runs of the same name are allowed. ``player_id`` says who does it.

    Raises:
        TextRefused: The name or the notes can't be accepted.
    """
    row = get(session, run_id, for_update=True)
    before = (row.name, row.notes)
    row.name = row.name if name is None else name
    row.notes = row.notes if notes is None else notes.strip()
    if row.name != before[0]:
        names = {"before": before[0], "after": row.name}
        audit.note(session, audit.Action.RENAMED, player_id, f"run {run_id}", **names)
    if row.notes != before[1]:
        audit.note(session, audit.Action.NOTES_WRITTEN, player_id, f"run {run_id}")
    note_change(session, "run", run_id)
    return row


def delete(session: Session, run_id: str, player_id: int | None = None) -> None:
    """Take a run out of every list; its games and files stay readable by id.

    ``restore`` brings it back.

    So rankings keep the games that they have borrowed from it, and runs that continue from it find
    its imitator.

    Raises:
        Conflict: The run is not over.
    """
    row = get(session, run_id, for_update=True)
    if not RunStatus(row.status).is_over:
        raise Conflict("This training is not over yet. Cancel it first, then delete it.")
    row.deleted_at = now()
    audit.note(session, audit.Action.DELETED, player_id, f"run {run_id}")
    note_change(session, "run", run_id)


def restore(session: Session, run_id: str, player_id: int | None = None) -> RunRow:
    """Bring a deleted run back, with everything it had.

    Raises:
        NotFound: There has never been such a run.
    """
    row = session.get(RunRow, run_id, with_for_update=True)
    if row is None:
        raise NotFound("There is no such training.")
    if row.deleted_at is not None:
        row.deleted_at = None
        audit.note(session, audit.Action.RESTORED, player_id, f"run {run_id}")
        note_change(session, "run", run_id)
    return row
