"""Consoles to replay on, one for each game."""

from __future__ import annotations

from tril.games.base import Console, Game

MAX_CONSOLES = 4
"""Most consoles that are kept; of an Atari game, one takes 0.7 MB and 0.1 s to load."""


class Consoles:
    """Consoles of the games that were used last; not thread-safe.

    Args:
        *consoles: Consoles that there are already.
    """

    def __init__(self, *consoles: Console) -> None:
        self._consoles = {console.game.name: console for console in consoles}

    def of(self, game: Game) -> Console:
        """Return the console of a game, whatever a behaviour sets of it."""
        # Taken out and put back, the dictionary is in the order of use.
        console = self._consoles.pop(game.name, None) or game.make_console()
        while len(self._consoles) >= MAX_CONSOLES:
            self._consoles.pop(next(iter(self._consoles))).close()
        console.game = game
        self._consoles[game.name] = console
        return console
