"""How much of the machine learning takes, so that games on it stay at 60 Hz."""

from __future__ import annotations

import os
from contextlib import suppress
from pathlib import Path

from tril.cores import core_count

AUTOGROUP = Path("/proc/self/autogroup")


def learning_threads(requested: int) -> int:
    """Return the number of threads of learning; 0 requests all cores open to this process."""
    return requested or core_count()


def lower_priority(niceness: int) -> None:
    """Lower the priority of this process and what it starts.

    Linux may share the cores out between sessions first and compare priorities only within a
    session (autogroups, sched(7)). A session that this process leads is lowered too.

    Args:
        niceness: Niceness from 0, as it is, to 19, when nothing else wants the cores.
    """
    os.nice(max(0, niceness - os.nice(0)))
    if hasattr(os, "getsid") and os.getsid(0) == os.getpid():
        with suppress(OSError):
            AUTOGROUP.write_text(str(niceness), encoding="utf-8")
