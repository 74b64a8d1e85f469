"""Slows learning down while people play on the same machine."""

from __future__ import annotations

import os
import time
from contextlib import suppress
from pathlib import Path

import torch

from tril.cores import core_count

NICENESS = 10
AUTOGROUP = Path("/proc/self/autogroup")
LONGEST_PAUSE_S = 0.25


class Throttle:
    """How much of the machine learning takes.

    The worker and the processes it starts always run at low priority, which is what keeps the
    game at 60 Hz. While active, learning also uses half of its threads and pauses between its
    units of work for as long as each took, at most a quarter of a second.

    Args:
        threads: Threads that learning may use.

    Attributes:
        active: Whether to slow down, because somebody plays.
        threads: Threads that learning may use.
    """

    def __init__(self, threads: int) -> None:
        self.active = False
        self.threads = threads
        self._used = 0
        self._worked_since = time.monotonic()

    def begin(self) -> None:
        """Begin work in the calling thread; torch counts threads for each thread separately."""
        self._used = 0
        self._use(self.threads)
        self._worked_since = time.monotonic()

    def pause(self) -> None:
        """Pause between two units of work if active; call it from the learning thread."""
        if not self.active:
            self._use(self.threads)
        else:
            self._use(max(1, self.threads // 2))
            time.sleep(min(LONGEST_PAUSE_S, time.monotonic() - self._worked_since))
        self._worked_since = time.monotonic()

    def _use(self, threads: int) -> None:
        if threads != self._used:
            torch.set_num_threads(threads)
            self._used = threads


def learning_threads(requested: int) -> int:
    """Return how many threads learning uses; 0 requests all cores that this process may use."""
    return requested or core_count()


def lower_priority() -> None:
    """Lower the priority of this process and what it starts.

    Linux may share the cores out between sessions first and compare priorities only within a
    session (autogroups, sched(7)). A session that this process leads is lowered too.
    """
    os.nice(max(0, NICENESS - os.nice(0)))
    if hasattr(os, "getsid") and os.getsid(0) == os.getpid():
        with suppress(OSError):
            AUTOGROUP.write_text(str(NICENESS))
