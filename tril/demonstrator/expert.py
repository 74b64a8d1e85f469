"""What the scripted player would do in any state of a game: the expert that DAgger asks.

It is privileged: it reads the emulator's memory and looks ahead on the saved game, which nothing
else that learns may do.
"""

from __future__ import annotations

import numpy as np

from tril.behaviours import Behaviour, Cell
from tril.demonstrator.plans import example_plans
from tril.demonstrator.player import Planner, Style
from tril.game.console import Console
from tril.game.episode import Episode, EpisodeState, Start
from tril.game.space_invaders import FRAMES_PER_STEP

EXPERT_STYLE = Style(pace=0.0, aim_px=0.0, wander_px=0.0, wait_steps=0.0)
"""Shoots as soon as it can and walks no further than it has to: who only sees the screen can learn
when to do what."""


def check_expert(behaviour: Behaviour) -> None:
    """Make sure that the expert knows what to do for a behaviour.

    Raises:
        Invalid: The demonstrator can't show it; says why and what to do.
    """
    example_plans(behaviour)


class Expert:
    """Says what to do in states of one game after the other, whoever plays them.

    In a state that nobody led it to it plans anew, for the targets that are left; as long as what
    it says is done, it goes on with its plan, as the scripted player does.
    """

    def __init__(self, behaviour: Behaviour, console: Console) -> None:
        """Learn what is to be shown.

        Args:
            behaviour: What is to be shown.
            console: Where it looks ahead; not the one that the games are played on.

        Raises:
            Invalid: The demonstrator can't show this behaviour.
        """
        check_expert(behaviour)
        assert behaviour.target is not None
        by_column = sorted(behaviour.target, key=lambda cell: (cell[1], cell[0]))
        self._order = behaviour.target if behaviour.ordered else tuple(by_column)
        self._episode = Episode(console, Start(0))
        self._planner: Planner | None = None
        self._wanted: list[Cell] = []
        self._made_at = 0
        self._plan: tuple[int, ...] = ()
        self._rng = np.random.default_rng()

    def begin(self, rng: np.random.Generator) -> None:
        """Forget the last game; the chances of the next one (which way to dodge) come from rng."""
        self._rng = rng
        self._planner = None
        self._plan = ()

    def action(self, state: EpisodeState) -> int:
        """Return what to do in the next step, 0 to 5.

        Args:
            state: The game between two steps, not ended.
        """
        done = state.actions[self._made_at :]
        n_done = len(done) // FRAMES_PER_STEP
        follows = self._planner is not None and done == _frames(self._plan[:n_done])
        if follows and n_done < len(self._plan):
            return self._plan[n_done]
        self._episode.restore(state)
        hit = [(one.row, one.column) for one in state.hits]
        # A missile that was under way when the planner was made may have hit anything.
        if self._planner is None or not follows or hit != self._wanted[: len(hit)]:
            self._wanted = [*hit, *(cell for cell in self._order if cell not in hit)]
            self._planner = Planner(self._episode, self._wanted, EXPERT_STYLE, self._rng)
        self._plan = tuple(self._planner.next_actions())
        self._made_at = len(state.actions)
        return self._plan[0]


def _frames(actions: tuple[int, ...]) -> bytes:
    return bytes(action for action in actions for _ in range(FRAMES_PER_STEP))
