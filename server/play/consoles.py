"""Consoles at hand, loaded while nobody plays.

The emulator holds Python's lock while it loads the ROM, 85 ms in which no game of the process
advances; while it runs frames it lets go of it. So a game's start and its replay may take place in
threads while others play, but loading may not.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager

from tril.game.console import Console, StartCache
from tril.game.episode import Start

PATIENCE_S = 2.0
"""How long somebody who needs a console waits for a moment in which nobody plays."""

BREATH_S = 0.3
"""Between two consoles loaded ahead, so that requests are answered in good time meanwhile."""


class ConsolePool:
    """Consoles, lent one at a time to threads; safe to use from several threads.

    All that were ever needed at the same time are kept, 0.7 MB each. They share the starts that
    were reached, so that a start takes at most 127 frames and mostly none.

    Args:
        n_ahead: How many are loaded ahead, whether or not they are needed.
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
        """How many there are, lent or idle."""
        return self._n_loaded

    def start(self) -> None:
        """Begin to load ahead."""
        self._thread.start()

    def stop(self) -> None:
        """Load no more ahead."""
        with self._changed:
            self._stopped = True
            self._changed.notify_all()
        if self._thread.is_alive():
            self._thread.join()

    @contextmanager
    def undisturbed(self) -> Iterator[None]:
        """Load none during a block, in which a game's clock runs."""
        with self._changed:
            self._n_clocks += 1
        try:
            yield
        finally:
            with self._changed:
                self._n_clocks -= 1
                self._changed.notify_all()

    def take(self) -> Console:
        """Take a console; loads one if none is idle. Call it in a thread, not in the loop."""
        give_up_at = time.monotonic() + PATIENCE_S
        with self._changed:
            while not self._idle and self._n_clocks:
                if not self._changed.wait(give_up_at - time.monotonic()):
                    break
            if self._idle:
                return self._idle.pop()
        with self._loading:
            with self._changed:
                if self._idle:  # the one that was just loaded ahead
                    return self._idle.pop()
            return self._load()

    def give_back(self, console: Console) -> None:
        """Return a console, whatever state it is in."""
        with self._changed:
            self._idle.append(console)
            self._changed.notify_all()

    @contextmanager
    def lent(self) -> Iterator[Console]:
        """Give a console for a block."""
        console = self.take()
        try:
            yield console
        finally:
            self.give_back(console)

    def _load(self) -> Console:
        """Load a console; only by whoever holds the lock for it."""
        console = Console(self._start_cache)
        # The reset holds Python's lock too, 4 ms; no other start needs one after this.
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
                self._changed.wait_for(lambda: self._stopped, BREATH_S)
