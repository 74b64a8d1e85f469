"""Consoles at hand: loading one takes 0.1 s, during which the game loop would stand still."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import contextmanager

from tril.game.console import Console


class ConsolePool:
    """Loaded consoles, lent one at a time to threads; safe to use from several threads.

    Args:
        n_kept: How many idle ones are kept.
    """

    def __init__(self, n_kept: int = 4) -> None:
        self._n_kept = n_kept
        self._idle: list[Console] = []
        self._lock = threading.Lock()

    def load(self, n: int) -> None:
        """Load consoles ahead of time, up to the number kept."""
        while True:
            with self._lock:
                if len(self._idle) >= min(n, self._n_kept):
                    return
            self.give_back(Console())

    def take(self) -> Console:
        """Take a console, loading one if none is idle. Call it in a thread, not in the loop."""
        with self._lock:
            if self._idle:
                return self._idle.pop()
        return Console()

    def give_back(self, console: Console) -> None:
        """Return a console, whatever state it is in."""
        with self._lock:
            if len(self._idle) < self._n_kept:
                self._idle.append(console)

    @contextmanager
    def lent(self) -> Iterator[Console]:
        """Give a console for a block."""
        console = self.take()
        try:
            yield console
        finally:
            self.give_back(console)
