"""Let child processes end with their parent, even if it is killed.

Imports only the standard library, so that a child watches its parent from the start.
"""

from __future__ import annotations

import os
import signal
import threading
import time

PARENT_VARIABLE = "TRIL_PARENT_PID"
POLL_S = 1.0
TERMINATION_TIMEOUT_S = 10.0


def child_environment() -> dict[str, str]:
    """Return the environment of a child that calls ``exit_with_parent``."""
    return {**os.environ, PARENT_VARIABLE: str(os.getpid())}


def exit_with_parent() -> None:
    """Send this process SIGTERM once its parent has ended, and exit if that has no effect.

    Does nothing in a process that was not started with ``child_environment``.
    """
    # Children of this process have another parent and must not inherit the variable.
    parent = os.environ.pop(PARENT_VARIABLE, None)
    if parent is not None:
        threading.Thread(
            target=_watch, args=(int(parent),), name="parent-watch", daemon=True
        ).start()


def _watch(parent: int) -> None:
    while os.getppid() == parent:
        time.sleep(POLL_S)
    os.kill(os.getpid(), signal.SIGTERM)
    time.sleep(TERMINATION_TIMEOUT_S)
    os._exit(1)
