"""The times by which games are played and kept."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import timedelta


@dataclass(frozen=True)
class PlayRules:
    """The times by which games are played and kept.

    Attributes:
        countdown: Whole seconds counted down before a game goes on.
        countdown_second_s: How long such a second lasts.
        save_every_s: Most seconds between commits of a game. With the time that a commit itself
            takes, less than a second of a game, 60 frames, is ever not on disk.
        stalled_after_s: A game is paused when its page draws nothing for so long.
        forgotten_after_s: A game without a page leaves this process's memory after so long; it
            goes on from what is saved.
        idle_after: A game that stands still before its page for so long, never begun or paused,
            becomes an unfinished recording.
        abandoned_after: A game that nobody plays for so long becomes an unfinished recording.
        decided_after: A finished game that nobody decided about is kept after so long.
        sweep_every_s: Seconds between looks for such games.
        max_games: Most games that one process plays at the same time; so many consoles are loaded.
    """

    countdown: int = 3
    countdown_second_s: float = 1.0
    save_every_s: float = 0.8
    stalled_after_s: float = 2.0
    forgotten_after_s: float = 60.0
    idle_after: timedelta = timedelta(minutes=10)
    abandoned_after: timedelta = timedelta(minutes=15)
    decided_after: timedelta = timedelta(hours=1)
    sweep_every_s: float = 30.0
    max_games: int = 32


DEFAULT_RULES = PlayRules()
"""The times by which people play."""
