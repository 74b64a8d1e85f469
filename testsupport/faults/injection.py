"""The kinds of fault: what is done, and what undoes it."""

from __future__ import annotations

import shutil
import signal
import subprocess
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import psutil

from testsupport.faults.members import Member, PostgresMember, StoreMember
from testsupport.faults.network import MAIN, Network
from tril.jobs.delivery import LOST_AFTER_S

KILL_S = (0.0, 2.0)
SHORT_PAUSE_S = (0.5, 8.0)
LONG_PAUSE_S = (LOST_AFTER_S + 3.0, LOST_AFTER_S + 15.0)
"""Long enough for another worker to take the run over."""
DATABASE_DOWN_S = (0.0, 15.0)
PARTITION_S = (3.0, 75.0)
DISK_S = (2.0, 15.0)
STORE_AWAY_S = (2.0, 45.0)
"""Longer than a request to the store may take, at most."""
CLOCK_S = (5.0, 20.0)
WRONG_BY_S = (60, 900)

WRITES = ("pwrite64", "fsync,fdatasync", "ftruncate", "rename", "openat")
"""System calls by which databases, checkpoints and artifacts are written, and opened."""

DELAY_US = 250_000


@dataclass
class Target:
    """What faults happen to.

    Attributes:
        members: Processes of Tril.
        database: The PostgreSQL server, if that is the database.
        store: The S3 server, if files are there.
        network: What lies between the hosts, if there are several.
        disk: Where the data folder is mounted, a file system of its own; None if it is not.
        disk_bytes: Size of that file system.
    """

    members: list[Member]
    database: PostgresMember | None = None
    store: StoreMember | None = None
    network: Network | None = None
    disk: Path | None = None
    disk_bytes: int = 0

    def of_kind(self, kind: str) -> list[Member]:
        """Return the processes of a kind."""
        return [member for member in self.members if member.name.partition(" ")[0] == kind]


Inject = Callable[[Target, np.random.Generator], None]


@dataclass(frozen=True)
class FaultKind:
    """A kind of fault.

    Attributes:
        inject: Does it, waits, and undoes it.
        is_possible: Whether it can be done here.
        weight: How often it is drawn, beside 1.
    """

    inject: Inject
    is_possible: Callable[[Target], bool] = field(default=lambda _target: True)
    weight: float = 1.0


def _kill(kind: str) -> Inject:
    def inject(target: Target, rng: np.random.Generator) -> None:
        member = _one(target.of_kind(kind), rng)
        member.kill()
        _wait(rng, KILL_S)
        member.start()

    return inject


def _kill_all(target: Target, rng: np.random.Generator) -> None:
    for member in target.members:
        member.kill()
    _wait(rng, KILL_S)
    for member in target.members:
        member.start()


def _stop(target: Target, rng: np.random.Generator) -> None:
    member = _one(target.members, rng)
    member.stop()
    member.start()


def _pause(kind: str, longest: tuple[float, float]) -> Inject:
    def inject(target: Target, rng: np.random.Generator) -> None:
        with _suspended(_one(target.of_kind(kind), rng).family()):
            _wait(rng, longest)

    return inject


def _kill_database(target: Target, rng: np.random.Generator) -> None:
    assert target.database is not None
    target.database.kill()
    _wait(rng, DATABASE_DOWN_S)
    target.database.start()


def _restart_database(target: Target, rng: np.random.Generator) -> None:
    assert target.database is not None
    target.database.send(signal.SIGQUIT)  # "immediate shutdown"
    while target.database.is_alive:
        time.sleep(0.02)
    _wait(rng, KILL_S)
    target.database.start()


def _pause_database(target: Target, rng: np.random.Generator) -> None:
    assert target.database is not None
    with _suspended(target.database.family()):
        _wait(rng, DATABASE_DOWN_S)


def _pause_store(target: Target, rng: np.random.Generator) -> None:
    assert target.store is not None
    with _suspended(target.store.family()):
        _wait(rng, STORE_AWAY_S)


def _skew_clock(target: Target, rng: np.random.Generator) -> None:
    clocks = [member.clock for member in target.members if member.clock is not None]
    clock = clocks[int(rng.integers(len(clocks)))]
    clock.set_wrong(int(rng.integers(*WRONG_BY_S)) * int(rng.choice([-1, 1])))
    try:
        _wait(rng, CLOCK_S)
    finally:
        clock.set_wrong(0)


def _partition(target: Target, rng: np.random.Generator) -> None:
    assert target.network is not None
    host = str(rng.choice([host for host in target.network.hosts if host != MAIN]))
    target.network.cut(host)
    try:
        _wait(rng, PARTITION_S)
    finally:
        target.network.join(host)


def _fill_disk(target: Target, rng: np.random.Generator) -> None:
    assert target.disk is not None
    # A page is kept, since the size must not be less than what is used meanwhile.
    _resize(target.disk, shutil.disk_usage(target.disk).used + 2**16)
    try:
        _wait(rng, DISK_S)
    finally:
        _resize(target.disk, target.disk_bytes)


def _traced_writes(change: Callable[[np.random.Generator], str], names: tuple[str, ...]) -> Inject:
    """Change what system calls do, of one process, by ptrace."""

    def inject(target: Target, rng: np.random.Generator) -> None:
        kinds = [member for member in target.members if member.name != "inference"]
        member, calls = _one(kinds, rng), str(rng.choice(names))
        command = ["strace", "-f", "-qq", "-o", "/dev/null", "-e", f"trace={calls}"]
        injected = ["-e", f"inject={calls}:{change(rng)}", "-p", str(member.pid)]
        tracer = subprocess.Popen([*command, *injected], stderr=subprocess.DEVNULL)
        try:
            _wait(rng, DISK_S)
        finally:
            tracer.terminate()
            tracer.wait()

    return inject


def _error(rng: np.random.Generator) -> str:
    """Fail from a call on, that one alone or every so many."""
    first, step = rng.integers(1, 8), rng.integers(0, 4)
    number = str(rng.choice(["EIO", "ENOSPC"]))
    return f"error={number}:when={first}" + (f"+{step}" if step else "")


_HAS_TWO_WORKERS = 2


def _with_two_workers(target: Target) -> bool:
    return len(target.of_kind("worker")) >= _HAS_TWO_WORKERS


def _with_database(target: Target) -> bool:
    return target.database is not None


def _with_store(target: Target) -> bool:
    return target.store is not None


def _with_clocks(target: Target) -> bool:
    return any(member.clock is not None for member in target.members)


def _with_strace(_target: Target) -> bool:
    return shutil.which("strace") is not None


KINDS: Mapping[str, FaultKind] = {
    "kill server": FaultKind(_kill("server"), weight=2.0),
    "kill worker": FaultKind(_kill("worker"), weight=3.0),
    "kill inference": FaultKind(_kill("inference")),
    "kill all": FaultKind(_kill_all),
    "stop a process": FaultKind(_stop),
    "pause server": FaultKind(_pause("server", SHORT_PAUSE_S)),
    "pause worker": FaultKind(_pause("worker", SHORT_PAUSE_S)),
    "pause worker for long": FaultKind(_pause("worker", LONG_PAUSE_S), _with_two_workers),
    "kill database": FaultKind(_kill_database, _with_database, weight=2.0),
    "restart database": FaultKind(_restart_database, _with_database, weight=2.0),
    "pause database": FaultKind(_pause_database, _with_database),
    "pause store": FaultKind(_pause_store, _with_store),
    "skew clock": FaultKind(_skew_clock, _with_clocks, weight=2.0),
    "partition": FaultKind(_partition, lambda target: target.network is not None, weight=4.0),
    "fill disk": FaultKind(_fill_disk, lambda target: target.disk is not None, weight=2.0),
    "fail writes": FaultKind(_traced_writes(_error, WRITES), _with_strace, weight=2.0),
    "slow writes": FaultKind(
        _traced_writes(lambda _rng: f"delay_enter={DELAY_US}", WRITES[:2]), _with_strace
    ),
}


def draw(target: Target, rng: np.random.Generator, only: set[str] | None = None) -> str:
    """Draw a kind of fault that is possible here.

    Args:
        target: What it is to happen to.
        rng: Draws.
        only: The kinds to draw from; None for all.
    """
    names = possible(target, only)
    weights = np.array([KINDS[name].weight for name in names])
    return str(rng.choice(names, p=weights / weights.sum()))


def possible(target: Target, only: set[str] | None = None) -> list[str]:
    """Return the kinds of fault that are possible here."""
    return [
        name
        for name, kind in KINDS.items()
        if kind.is_possible(target) and (only is None or name in only)
    ]


def mount(folder: Path, size_bytes: int) -> None:
    """Give a folder a file system of its own; needs root."""
    folder.mkdir(parents=True, exist_ok=True)
    options = f"size={size_bytes},mode=0700"
    subprocess.run(["mount", "-t", "tmpfs", "-o", options, "tmpfs", folder], check=True)


def unmount(folder: Path) -> None:
    """Remove what ``mount`` made, with what is in it."""
    subprocess.run(["umount", "--lazy", folder], check=True)


def _resize(folder: Path, size_bytes: int) -> None:
    options = f"remount,size={size_bytes}"
    subprocess.run(["mount", "-o", options, folder], check=True)


def _one(members: list[Member], rng: np.random.Generator) -> Member:
    return members[int(rng.integers(len(members)))]


def _wait(rng: np.random.Generator, between_s: tuple[float, float]) -> None:
    time.sleep(float(rng.uniform(*between_s)))


@contextmanager
def _suspended(processes: list[psutil.Process]) -> Iterator[None]:
    try:
        for process in processes:
            with suppress(psutil.NoSuchProcess):
                process.suspend()
        yield
    finally:
        for process in processes:
            with suppress(psutil.NoSuchProcess):
                process.resume()
