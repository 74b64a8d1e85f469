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

from tril.games import DEFAULT_GAME, game_named
from tril.games.base import Console, Game, StartCache

PATIENCE_S = 2.0
"""Longest wait for a moment without a running game before a console is loaded anyway."""

PAUSE_S = 0.3
"""Between two consoles loaded ahead, so that requests are served meanwhile."""


MAX_IDLE_OTHERS = 8
"""Most idle consoles of other games than the one that is loaded ahead."""


class ConsolePool:
    """A thread-safe pool of consoles of all games.

    A console takes 0.7 MB. Consoles of a game share the starts that were reached, so that a start
    takes at most 127 frames and mostly none. Of other games than the one that is loaded ahead, few
    idle consoles are kept.

    Args:
        n_ahead: Number of consoles to load ahead.
        game: Name of the game that they are loaded ahead of.
    """

    def __init__(self, n_ahead: int = 0, game: str = DEFAULT_GAME) -> None:
        self._n_ahead = n_ahead
        self._game = game
        self._n_loaded = 0
        self._idle: list[Console] = []
        self._start_caches: dict[str, StartCache] = {}
        self._n_clocks = 0
        self._stopped = False
        self._changed = threading.Condition()
        self._loading = threading.Lock()
        self._thread = threading.Thread(target=self._load_ahead, name="consoles", daemon=True)

    @property
    def n_loaded(self) -> int:
        """Number of loaded consoles of the game that is loaded ahead, taken or idle."""
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

    def take(self, game: Game) -> Console:
        """Take an idle console of a game, or load one; blocks, so call it in a thread."""
        give_up_at = time.monotonic() + PATIENCE_S
        with self._changed:
            while (idle := self._pop(game)) is None and self._n_clocks:
                if not self._changed.wait(give_up_at - time.monotonic()):
                    break
            if idle is not None:
                return idle
        with self._loading:
            with self._changed:
                idle = self._pop(game)  # loaded ahead meanwhile
            return idle or self._load(game)

    def give_back(self, console: Console) -> None:
        """Return a console, in any state; raises ValueError if it is here already."""
        surplus: list[Console] = []
        with self._changed:
            if any(console is idle for idle in self._idle):
                raise ValueError("Expected a console that was taken, got an idle one.")
            self._idle.append(console)
            other_games = [idle for idle in self._idle if idle.game.name != self._game]
            if len(other_games) > MAX_IDLE_OTHERS:
                surplus = other_games[: len(other_games) - MAX_IDLE_OTHERS]
                self._idle = [idle for idle in self._idle if idle not in surplus]
            self._changed.notify_all()
        for idle in surplus:
            idle.close()

    def _pop(self, game: Game) -> Console | None:
        """Take an idle console of a game out; call with the condition's lock held."""
        for at in reversed(range(len(self._idle))):
            if self._idle[at].game.name == game.name:
                console = self._idle.pop(at)
                console.game = game
                return console
        return None

    @contextmanager
    def lent(self, game: Game) -> Iterator[Console]:
        """Take a console of a game for a block."""
        console = self.take(game)
        try:
            yield console
        finally:
            self.give_back(console)

    def _load(self, game: Game) -> Console:
        """Load a console; call with the lock for loading held."""
        console = game.make_console(self._start_caches.setdefault(game.name, {}))
        # The first reset holds Python's lock too, for 4 ms; later starts restore a state.
        console.start(game.starts.training[0])
        if game.name == self._game:
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
                    self.give_back(self._load(game_named(self._game)))
            with self._changed:
                self._changed.wait_for(lambda: self._stopped, PAUSE_S)
