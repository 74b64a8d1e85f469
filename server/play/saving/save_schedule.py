"""The schedule of commits, which spreads a process's games over several. Pure."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TypeVar

N_SLOTS = 4
"""Number of commits within the time between two commits of a game."""

_Game = TypeVar("_Game")


def games_due(saved_s: Mapping[_Game, float], now_s: float, every_s: float) -> list[_Game]:
    """Return the games to commit now, those saved longest ago first.

    They are a share of the games, so that games which began together spread over the slots, and
    all that would be late if they waited for the next slot.

    Args:
        saved_s: When each game was last saved, or tried to be.
        now_s: The current time by the same clock.
        every_s: Longest time between two commits of a game.
    """
    waiting = sorted(saved_s, key=lambda game: saved_s[game])
    share = len(waiting) // (N_SLOTS - 1)
    late_s = every_s * (1 - 1 / N_SLOTS)
    # Half a slot's tolerance, since slots are not exact to the millisecond.
    due_s = late_s - every_s / N_SLOTS / 2
    return [game for n, game in enumerate(waiting) if n < share or now_s - saved_s[game] >= due_s]
