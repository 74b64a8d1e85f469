"""Whose turn it is to be saved, so that a commit is never of all games at once. Pure."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TypeVar

TURNS = 4
"""Into how many turns the time between two commits of a game is divided."""

_Game = TypeVar("_Game")


def whose_turn(last_s: Mapping[_Game, float], now_s: float, every_s: float) -> list[_Game]:
    """Return the games to save in this turn, those that were saved longest ago first.

    They are a part of the games, so that also those that began together spread over the turns, and
    all that would be late if they waited for the next turn.

    Args:
        last_s: When each game was saved, or tried to be, last.
        now_s: The present, by the same clock.
        every_s: Within what time each game is to be saved again, if turns come in time.
    """
    waiting = sorted(last_s, key=lambda game: last_s[game])
    share = len(waiting) // (TURNS - 1)
    late_s = every_s * (1 - 1 / TURNS)
    # Half a turn's tolerance, since turns do not come to the millisecond.
    due_s = late_s - every_s / TURNS / 2
    return [game for n, game in enumerate(waiting) if n < share or now_s - last_s[game] >= due_s]
