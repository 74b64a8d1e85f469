"""Training makes way for people who play on the same machine."""

from __future__ import annotations

import os
import time
from contextlib import suppress
from pathlib import Path

import torch

from tril.cores import core_count

NICENESS = 10
AUTOGROUP = Path("/proc/self/autogroup")
LONGEST_REST_S = 0.25


class Throttle:
    """How much of the machine learning takes.

    The worker and the processes it starts always run at low priority, which is what keeps the
    game at 60 Hz. While somebody plays, learning also uses half of its threads and rests between
    its units of work for as long as each took, at most a quarter of a second.

    Args:
        threads: Threads that learning may use.

    Attributes:
        play_is_on: Whether somebody plays; set by who looks.
        threads: Threads that learning may use.
    """

    def __init__(self, threads: int) -> None:
        self.play_is_on = False
        self.threads = threads
        self._used = 0
        self._worked_since = time.monotonic()

    def begin(self) -> None:
        """Take up work in this thread; the number of threads is a thread's own."""
        self._used = 0
        self._use(self.threads)
        self._worked_since = time.monotonic()

    def make_way(self) -> None:
        """Rest between two units of work if somebody plays; call it from the learning thread."""
        if not self.play_is_on:
            self._use(self.threads)
        else:
            self._use(max(1, self.threads // 2))
            time.sleep(min(LONGEST_REST_S, time.monotonic() - self._worked_since))
        self._worked_since = time.monotonic()

    def _use(self, threads: int) -> None:
        if threads != self._used:
            torch.set_num_threads(threads)
            self._used = threads


def learning_threads(wanted: int) -> int:
    """Return how many threads learning uses: those wanted, or all cores this process may use."""
    return wanted or core_count()


def lower_priority() -> None:
    """Make this process, and what it starts, give way to others.

    Linux may share the cores out between sessions first, and looks at the processes' priorities
    within a session only (autogroups, sched(7)). A session that this process leads is lowered too.
    """
    os.nice(max(0, NICENESS - os.nice(0)))
    if hasattr(os, "getsid") and os.getsid(0) == os.getpid():
        with suppress(OSError):
            AUTOGROUP.write_text(str(NICENESS))
