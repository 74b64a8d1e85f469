"""Openings: a walk before the game is the player's, so that starts differ by more than a delay.

Idle frames alone hardly make another game: one start is the other a moment later. After an opening
the cannon stands elsewhere, and bombs fall elsewhere.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tril.games.space_invaders.memory import Action
from tril.games.space_invaders.starts import Start, evaluation_start

LEGS = 3
MAX_LEG_STEPS = 14
_ACTIONS = (Action.RIGHT, Action.RIGHT, Action.LEFT, Action.NOOP)
"""Of a leg, equally likely: the cannon begins at the left wall."""

_EVALUATION = 1
"""Seed of the evaluation openings, the first with which the cannon survives all of them."""

_REDRAWN = {9: 2}
"""Seeds of the openings that seed 1 would end with a bomb that no move avoids."""


@dataclass(frozen=True)
class Opening:
    """A start and the steps that are played before the player's first.

    They are part of the episode: they count towards its length, and a recording holds them.

    Attributes:
        start: How the game begins.
        actions: The action of each step; none fires.
    """

    start: Start
    actions: tuple[Action, ...]


def start_of(beginning: Start | Opening) -> Start:
    """Return the start of a game that begins with an opening or without."""
    return beginning.start if isinstance(beginning, Opening) else beginning


def draw_opening(start: Start, rng: np.random.Generator) -> Opening:
    """Draw a walk of three legs, each of one action, held for 0 to 14 steps."""
    actions: list[Action] = []
    for _ in range(LEGS):
        action = _ACTIONS[int(rng.integers(len(_ACTIONS)))]
        actions += [action] * int(rng.integers(MAX_LEG_STEPS, endpoint=True))
    return Opening(start, tuple(actions))


def evaluation_opening(number: int) -> Opening:
    """Return the opening of an evaluation start, fixed like the start itself and survived.

    Raises:
        UnknownStart: The number is out of range.
    """
    seed = _REDRAWN.get(number, _EVALUATION)
    return draw_opening(evaluation_start(number), np.random.default_rng((seed, number)))


def evaluation_beginning(number: int, openings: bool) -> Start | Opening:
    """Return where the game of an evaluation start begins, with its opening or without.

    Raises:
        UnknownStart: The number is out of range.
    """
    return evaluation_opening(number) if openings else evaluation_start(number)
