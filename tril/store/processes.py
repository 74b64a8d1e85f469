"""Which processes of Tril are alive."""

from __future__ import annotations

import os
import platform
import time
from dataclasses import dataclass
from datetime import datetime, timedelta
from functools import cache
from pathlib import Path
from typing import Any

from sqlalchemy import delete, select, update
from sqlalchemy.orm import Session

from tril.store.changes import note_change
from tril.store.database import database_now
from tril.store.models import ProcessRow

ALIVE_FOR = timedelta(seconds=15)
"""A process whose heartbeat is older is not alive."""

REPLACED_AFTER = timedelta(minutes=5)
"""A process that has been silent for longer is not listed if another has taken its place."""

FORGOTTEN_AFTER = timedelta(days=1)


@dataclass(frozen=True)
class ProcessIdentity:
    """Tells a process from every other one, also from a later one with the same id.

    Attributes:
        machine: The boot of the machine and the namespace of its process ids; the host's name
            where the system tells neither.
        pid: The process's id.
        started: Clock ticks from the boot to the process's start; empty where that is not told.
    """

    machine: str
    pid: int
    started: str

    @classmethod
    def of(cls, pid: int) -> ProcessIdentity:
        """Return the identity of a process of this machine that is alive."""
        return cls(_machine(), pid, _started(pid) or "")

    @property
    def has_ended(self) -> bool:
        """Whether the process is known to have ended; of other machines nothing is known."""
        if self.machine != _machine():
            return False
        started = _started(self.pid)
        # Another user's process may hide when it started.
        return started is None or (started != self.started and "" not in {started, self.started})

    @property
    def is_running(self) -> bool:
        """Whether the process is known to live; of other machines and containers nothing is known.

        Where the system does not tell when a process started, a later one may have its id.
        """
        is_told = self.machine == _machine() and self.started != ""
        return is_told and _started(self.pid) == self.started

    @property
    def age_s(self) -> float | None:
        """Seconds since the process began; None of other machines and where that is not told."""
        if self.machine != _machine() or not self.started:
            return None
        ticks_per_s = os.sysconf("SC_CLK_TCK")
        return time.clock_gettime(time.CLOCK_BOOTTIME) - int(self.started) / ticks_per_s


@cache
def _machine() -> str:
    try:
        boot = Path("/proc/sys/kernel/random/boot_id").read_text(encoding="utf-8").strip()
        return f"{boot} {Path('/proc/self/ns/pid').readlink()}"
    except OSError:
        return platform.node()


def _started(pid: int) -> str | None:
    """Return when a process started, empty where that is not told; None if it has ended."""
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return None
    except PermissionError:
        pass
    try:
        # The name before the closing bracket may hold anything, see proc_pid_stat(5).
        stat = Path(f"/proc/{pid}/stat").read_bytes().decode(errors="replace")
        state, *fields = stat.rpartition(")")[2].split()
    except OSError:
        return ""
    return None if state in "ZX" else fields[18]


@dataclass(frozen=True)
class ProcessStatus:
    """What is known of one process.

    Attributes:
        name: Unique name, e.g. "worker-0-3f9a2c1d".
        kind: "server", "worker" or "inference".
        alive: Whether it is known to live, or its heartbeat is fresh and it is not known to have
            ended.
        busy: Whether it is alive without a fresh heartbeat, e.g. since the machine is overloaded.
        details: Details that the process reports.
    """

    name: str
    kind: str
    alive: bool
    busy: bool
    details: dict[str, Any]


def is_fresh(session: Session, heartbeat_at: datetime | None) -> bool:
    """Whether a heartbeat, written by the database's clock, is recent enough to count."""
    return heartbeat_at is not None and _is_recent(heartbeat_at, database_now(session))


def _is_recent(heartbeat_at: datetime, moment: datetime) -> bool:
    """Whether a heartbeat is at most as old as one that counts; none is of a later moment.

    Otherwise a process that ended before the clock was set back would live on until then.
    """
    return -ALIVE_FOR < moment - heartbeat_at < ALIVE_FOR


def beat(
    session: Session,
    name: str,
    kind: str,
    details: dict[str, Any],
    identity: ProcessIdentity | None = None,
) -> None:
    """Write a process's heartbeat; tells the pages when it is new or says something new.

    Args:
        session: The transaction.
        name: Unique name of the process.
        kind: "server", "worker" or "inference".
        details: Details that the process reports.
        identity: Tells when it has ended without a word; this process by default.
    """
    identity = identity or ProcessIdentity.of(os.getpid())
    row = session.get(ProcessRow, name, with_for_update=True)
    if row is None:
        row = ProcessRow(name=name, kind=kind)
        session.add(row)
        note_change(session, "system", name)
    elif row.details != details or not is_fresh(session, row.heartbeat_at):
        note_change(session, "system", name)
    row.kind, row.details, row.heartbeat_at = kind, details, database_now(session)
    row.machine, row.pid, row.started = identity.machine, identity.pid, identity.started


def report_details(session: Session, name: str, details: dict[str, Any]) -> None:
    """Write a process's details before its next heartbeat, without notifying pages."""
    session.execute(update(ProcessRow).where(ProcessRow.name == name).values(details=details))


def leave(session: Session, name: str) -> None:
    """Note that a process has ended in good order, and forget those long gone."""
    session.execute(
        delete(ProcessRow).where(
            (ProcessRow.name == name)
            | (ProcessRow.heartbeat_at < database_now(session) - FORGOTTEN_AFTER)
        )
    )
    note_change(session, "system", name)


def statuses(session: Session) -> list[ProcessStatus]:
    """Return every process with a heartbeat of the last day, by name.

    Left out are those that have been silent for a while and were replaced: a process of the same
    kind that began on the same machine after their last heartbeat is alive.
    """
    moment = database_now(session)
    rows = session.scalars(
        select(ProcessRow)
        .where(ProcessRow.heartbeat_at > moment - FORGOTTEN_AFTER)
        .order_by(ProcessRow.name)
    ).all()
    fresh = {row.name for row in rows if _is_recent(row.heartbeat_at, moment)}
    alive = {
        row.name for row in rows if (row.name in fresh and not _has_ended(row)) or _is_running(row)
    }
    youngest: dict[tuple[str, str | None], timedelta] = {}
    for row in rows:
        age_s = _age_s(row)
        if row.name in alive and age_s is not None:
            place, age = (row.kind, row.machine), timedelta(seconds=age_s)
            youngest[place] = min(age, youngest.get(place, age))

    def is_replaced(row: ProcessRow) -> bool:
        silent_for = moment - row.heartbeat_at
        age = youngest.get((row.kind, row.machine))
        return silent_for >= REPLACED_AFTER and age is not None and age < silent_for

    return [
        ProcessStatus(row.name, row.kind, row.name in alive, row.name in alive - fresh, row.details)
        for row in rows
        if row.name in alive or not is_replaced(row)
    ]


def is_kind_alive(session: Session, kind: str) -> bool:
    """Whether a process of this kind is alive."""
    return any(status.alive for status in statuses(session) if status.kind == kind)


def is_gpu_worker_alive(session: Session) -> bool:
    """Whether a worker that learns on a GPU is alive."""
    workers = [status for status in statuses(session) if status.alive and status.kind == "worker"]
    return any(worker.details.get("gpu") for worker in workers)


def has_ended(session: Session, name: str) -> bool:
    """Whether a process is known to have ended; one that was never heard of is not."""
    row = session.get(ProcessRow, name, populate_existing=True)
    return row is not None and _has_ended(row)


def is_at_work(session: Session, name: str, run_id: str) -> bool:
    """Whether a worker is known to live and may be at a run, however long it was silent.

    On an overloaded machine heartbeats are late. One in time that does not name the run tells that
    the worker has left it.
    """
    row = session.get(ProcessRow, name, populate_existing=True)
    if row is None or not _is_running(row):
        return False
    return run_id in row.details.get("runs", ()) or not is_fresh(session, row.heartbeat_at)


def _is_running(row: ProcessRow) -> bool:
    identity = _identity(row)
    return identity is not None and identity.is_running


def _has_ended(row: ProcessRow) -> bool:
    identity = _identity(row)
    return identity is not None and identity.has_ended


def _age_s(row: ProcessRow) -> float | None:
    identity = _identity(row)
    return None if identity is None else identity.age_s


def _identity(row: ProcessRow) -> ProcessIdentity | None:
    if row.machine is None or row.pid is None or row.started is None:
        # Of an earlier version.
        return None
    return ProcessIdentity(row.machine, row.pid, row.started)
