"""Waiting for what happens in another process or thread."""

from __future__ import annotations

import time
from collections.abc import Callable

PATIENCE_S = 300.0
LOOK_EVERY_S = 0.05


def wait_until(
    holds: Callable[[], bool],
    patience_s: float = PATIENCE_S,
    what_was_said: Callable[[], str] = lambda: "",
) -> None:
    """Wait until something holds.

    Args:
        holds: Asked again and again.
        patience_s: Seconds after which this fails.
        what_was_said: What is known about why it does not hold.
    """
    give_up_at = time.monotonic() + patience_s
    while not holds():
        if time.monotonic() > give_up_at:
            raise AssertionError(f"It did not happen in {patience_s:.0f} s.\n{what_was_said()}")
        time.sleep(LOOK_EVERY_S)
