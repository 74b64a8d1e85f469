"""What would happen next in a game, for networks to foresee from its screens.

In each state the cannon shoots, if it can, and then stays where it is or goes to one side: will it
be hit, how soon, and which alien does the shot hit? The answers come from the emulator. They are
of use for all behaviours and say nothing of any.
"""

from __future__ import annotations

from itertools import product

import numpy as np
import numpy.typing as npt

from tril.games.atari.starts import AtariStart
from tril.games.base import Console
from tril.games.space_invaders.ends import DEATHS
from tril.games.space_invaders.memory import COLUMNS, FRAMES_PER_STEP, ROWS, Action
from tril.play.episode import Episode, EpisodeState

MOVES = (
    (Action.FIRE, Action.NOOP),
    (Action.LEFTFIRE, Action.LEFT),
    (Action.RIGHTFIRE, Action.RIGHT),
)
"""The first step's action, which shoots, and that of all further steps."""

HIT_WITHIN = (2, 4, 6, 8, 12, 16)
"""Steps within which the cannon is hit or not."""

N_HITS = len(MOVES) * len(HIT_WITHIN)
N_OUTCOMES = N_HITS + len(MOVES) * ROWS * COLUMNS

_NO_END = 1_000_000
"""Frames of a game that does not run out of time."""


class Lookahead:
    """Tries the moves on a game of its own.

    Args:
        console: The console that they are played on; not that of the games looked at.
    """

    def __init__(self, console: Console) -> None:
        self._episode = Episode(console, AtariStart(0), max_frames=_NO_END)

    def outcomes(self, state: EpisodeState) -> npt.NDArray[np.bool_]:
        """Return the outcomes of each move from a saved game, between two steps.

        Returns:
            bool (N_OUTCOMES,): for each move whether the cannon is hit within each number of
            steps, then for each move which alien of the full grid the shot hits, row by row. A
            cannon whose missile is in the air cannot shoot. Nothing happens in a game that is over
            but that the cannon was hit, if it was.
        """
        hits = np.full((len(MOVES), len(HIT_WITHIN)), state.end in DEATHS)
        shots = np.zeros((len(MOVES), ROWS, COLUMNS), np.bool_)
        for move, (first, further) in enumerate(MOVES if state.end is None else ()):
            died_after = self._play(state, first, further)
            hits[move] = [died_after <= steps for steps in HIT_WITHIN]
            new_hits = self._episode.taken[len(state.taken) :]
            if new_hits and not state.readout["missile_in_air"]:
                shots[move, new_hits[0].row, new_hits[0].column] = True
        return np.concatenate([hits.ravel(), shots.ravel()])

    def _play(self, state: EpisodeState, first: Action, further: Action) -> int:
        """Play one move and return after how many steps the cannon was hit, or one too many."""
        self._episode.restore(state)
        for step, _ in product(range(HIT_WITHIN[-1]), range(FRAMES_PER_STEP)):
            self._episode.advance(first if step == 0 else further)
            if self._episode.end is not None:
                if self._episode.end in DEATHS:
                    return step + 1
                break
        return HIT_WITHIN[-1] + 1
