"""Varied play of any game: by its scripted player, if it has one, else at random."""

from __future__ import annotations

from collections.abc import Mapping
from importlib import import_module

import numpy as np

from tril.demonstrators.random_play import play_randomly
from tril.games.base import Console
from tril.recording import Verified

_PLAYERS: Mapping[str, str] = {"space_invaders": "tril.demonstrators.space_invaders.varied_play"}
"""Modules whose `play_varied` plays a game in a better way than at random, by game."""


def has_player(game: str) -> bool:
    """Return whether a game, by its name, has a scripted player."""
    return game in _PLAYERS


def play_varied(rng: np.random.Generator, console: Console) -> Verified:
    """Play one varied game to its end and verify the recording.

    Args:
        rng: Source of all draws.
        console: The console to play on.

    Raises:
        RecordingRefused: The replay differs, because the game is not deterministic.
    """
    module = _PLAYERS.get(console.game.name)
    if module is None:
        return play_randomly(rng, console)
    played: Verified = import_module(module).play_varied(rng, console)
    return played
