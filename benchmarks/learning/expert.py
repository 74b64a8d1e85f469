"""The scripted player in any state of a game, however it came about: a yardstick for policies.

It is privileged: it reads the RAM and looks ahead on the saved game. No learner may.
"""

from __future__ import annotations

import numpy as np

from tril.demonstrators.space_invaders.plans import example_plans
from tril.demonstrators.space_invaders.player import Planner, PlayStyle
from tril.games.atari.starts import AtariStart
from tril.games.base import Cell, Console
from tril.games.behaviours import Behaviour
from tril.games.space_invaders.memory import FRAMES_PER_STEP
from tril.play.episode import Episode, EpisodeState

EXPERT_STYLE = PlayStyle(pace=0.0, aim_px=0.0, wander_px=0.0, wait_steps=0.0)
"""Shoots as soon as possible and walks no further than necessary, so that the timing can be learned
from the screen alone."""


class Expert:
    """Returns actions for the states of games that any policy may play.

    It follows its plan while its actions are taken, as the scripted player does, and otherwise
    replans for the remaining targets.
    """

    def __init__(self, behaviour: Behaviour, console: Console) -> None:
        """Make an expert for a behaviour.

        Args:
            behaviour: The behaviour to show.
            console: The console for look-ahead; not the one that the games are played on.

        Raises:
            Invalid: The demonstrator can't show this behaviour.
        """
        example_plans(behaviour)
        assert behaviour.target is not None
        by_column = sorted(behaviour.target, key=lambda cell: (cell[1], cell[0]))
        self._order = behaviour.target if behaviour.ordered else tuple(by_column)
        self._episode = Episode(console, AtariStart(0))
        self._planner: Planner | None = None
        self._targets: list[Cell] = []
        self._made_at = 0
        self._plan: tuple[int, ...] = ()
        self._rng = np.random.default_rng()

    def begin(self, rng: np.random.Generator) -> None:
        """Begin a new game; rng decides which way to dodge."""
        self._rng = rng
        self._planner = None
        self._plan = ()

    def action(self, state: EpisodeState) -> int:
        """Return the action for the next step, 0 to 5, given a game between two steps."""
        executed = state.actions[self._made_at :]
        n_done = len(executed) // FRAMES_PER_STEP
        follows = self._planner is not None and executed == _frames(self._plan[:n_done])
        if follows and n_done < len(self._plan):
            return self._plan[n_done]
        self._episode.restore(state)
        hit = [item.cell for item in state.taken]
        # A missile in flight when the planner was made may have hit any alien.
        if self._planner is None or not follows or hit != self._targets[: len(hit)]:
            self._targets = [*hit, *(cell for cell in self._order if cell not in hit)]
            self._planner = Planner(self._episode, self._targets, EXPERT_STYLE, self._rng)
        self._plan = tuple(self._planner.next_actions())
        self._made_at = len(state.actions)
        return self._plan[0]


def _frames(actions: tuple[int, ...]) -> bytes:
    return bytes(action for action in actions for _ in range(FRAMES_PER_STEP))
