"""Timing and limits of games in a process."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import timedelta


@dataclass(frozen=True)
class PlayRules:
    """Timing and limits of games in a process.

    Attributes:
        countdown: Whole seconds counted down before a game resumes.
        countdown_second_s: Duration of one such second.
        save_every_s: Longest time between commits of a game, seconds. With the time that a commit
            takes, a crash loses less than a second of a game, 60 frames.
        stalled_after_s: Seconds without an acknowledgement after which a game is paused.
        forgotten_after_s: Seconds after which a game without a page is unloaded from memory.
        idle_after: When a game that was never begun, or was paused, before its page ends as an
            unfinished recording.
        abandoned_after: When a game that nobody plays ends as an unfinished recording.
        decided_after: When a finished game that its player neither kept nor discarded is kept.
        sweep_every_s: Seconds between looks for such games.
        rewinds_at_once: How often a game may be rewound without a pause. Each time what was played
            is kept as a recording.
        rewind_every_s: Seconds until one more is allowed.
        max_games: Most games in one process; as many consoles are loaded ahead.
        leaving_s: Longest wait of a page for places to watch games that its player's other pages
            are about to give up, seconds.
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
    rewinds_at_once: int = 10
    rewind_every_s: float = 3.0
    max_games: int = 32
    leaving_s: float = 5.0


DEFAULT_RULES = PlayRules()
