"""A pool of consoles, loaded while no game runs.

The emulator holds Python's lock while it loads the ROM, 85 ms in which no game of the process
advances, and releases it while it runs frames. So games may start and be replayed in threads while
others run, but consoles may not be loaded.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager

from tril.games.atari.console import Console, StartCache
from tril.play.episode import Start

PATIENCE_S = 2.0
"""Longest wait for a moment without a running game before a console is loaded anyway."""

PAUSE_S = 0.3
"""Between two consoles loaded ahead, so that requests are served meanwhile."""


class ConsolePool:
    """A thread-safe pool of consoles.

    It never shrinks; a console takes 0.7 MB. Consoles share the starts that were reached, so that
    a start takes at most 127 frames and mostly none.

    Args:
        n_ahead: Number of consoles to load ahead.
    """

    def __init__(self, n_ahead: int = 0) -> None:
        self._n_ahead = n_ahead
        self._n_loaded = 0
        self._idle: list[Console] = []
        self._start_cache: StartCache = {}
        self._n_clocks = 0
        self._stopped = False
        self._changed = threading.Condition()
        self._loading = threading.Lock()
        self._thread = threading.Thread(target=self._load_ahead, name="consoles", daemon=True)

    @property
    def n_loaded(self) -> int:
        """Number of loaded consoles, taken or idle."""
        return self._n_loaded

    def start(self) -> None:
        """Start loading ahead."""
        self._thread.start()

    def stop(self) -> None:
        """Stop loading ahead."""
        with self._changed:
            self._stopped = True
            self._changed.notify_all()
        if self._thread.is_alive():
            self._thread.join()

    @contextmanager
    def loading_suspended(self) -> Iterator[None]:
        """Suspend loading for a block in which a game's clock runs."""
        with self._changed:
            self._n_clocks += 1
        try:
            yield
        finally:
            with self._changed:
                self._n_clocks -= 1
                self._changed.notify_all()

    def take(self) -> Console:
        """Take an idle console, or load one; blocks, so call it in a thread."""
        give_up_at = time.monotonic() + PATIENCE_S
        with self._changed:
            while not self._idle and self._n_clocks:
                if not self._changed.wait(give_up_at - time.monotonic()):
                    break
            if self._idle:
                return self._idle.pop()
        with self._loading:
            with self._changed:
                if self._idle:  # loaded ahead meanwhile
                    return self._idle.pop()
            return self._load()

    def give_back(self, console: Console) -> None:
        """Return a console, in any state; raises ValueError if it is here already."""
        with self._changed:
            if any(console is idle for idle in self._idle):
                raise ValueError("Expected a console that was taken, got an idle one.")
            self._idle.append(console)
            self._changed.notify_all()

    @contextmanager
    def lent(self) -> Iterator[Console]:
        """Take a console for a block."""
        console = self.take()
        try:
            yield console
        finally:
            self.give_back(console)

    def _load(self) -> Console:
        """Load a console; call with the lock for loading held."""
        console = Console(self._start_cache)
        # The first reset holds Python's lock too, for 4 ms; later starts restore a state.
        console.start(Start(0))
        self._n_loaded += 1
        return console

    def _load_ahead(self) -> None:
        while True:
            with self._changed:
                while not self._stopped and (self._n_clocks or self._n_loaded >= self._n_ahead):
                    self._changed.wait()
                if self._stopped:
                    return
            with self._loading:
                if self._n_loaded < self._n_ahead:
                    self.give_back(self._load())
            with self._changed:
                self._changed.wait_for(lambda: self._stopped, PAUSE_S)
