"""An episode: one game on a console from its start to its end."""

from dataclasses import dataclass
from enum import StrEnum

import numpy as np
import numpy.typing as npt

from tril.errors import Conflict
from tril.games.atari.console import Console, ConsoleState
from tril.games.space_invaders import memory as game
from tril.games.space_invaders.grid import (
    AlienGrid,
    AlienGridState,
    Formation,
    cleared,
    in_play,
    landed,
    missile_in_air,
    player_hit,
)
from tril.games.space_invaders.starts import (
    EVALUATION_START_COUNT,
    EVALUATION_STARTS,
    TRAINING_IDLE_FRAMES,
    Start,
    UnknownStart,
    draw_start,
    evaluation_number,
    evaluation_start,
)

__all__ = [
    "DEATHS",
    "EVALUATION_STARTS",
    "EVALUATION_START_COUNT",
    "TRAINING_IDLE_FRAMES",
    "EndReason",
    "Ending",
    "Episode",
    "EpisodeEnded",
    "EpisodeState",
    "Hit",
    "Start",
    "UnknownStart",
    "draw_start",
    "evaluation_number",
    "evaluation_start",
]


class EpisodeEnded(Conflict):
    """The episode is over."""


class Ending(StrEnum):
    """When the player's death ends an episode.

    HIT: at the frame of the hit. LIFE_COUNTER: when the emulator's count of lives drops, 128 to 131
    frames later, as in the published work.
    """

    HIT = "hit"
    LIFE_COUNTER = "life_counter"


class EndReason(StrEnum):
    """Why an episode ended; the first in this order if several apply."""

    HIT = "hit"
    LIVES = "lives"
    LANDED = "landed"
    CLEARED = "cleared"
    STEPS = "steps"


DEATHS = frozenset({EndReason.HIT, EndReason.LIVES})
"""The ends that the player's death brings, by either rule."""


@dataclass(frozen=True)
class Hit:
    """An alien that was shot.

    Attributes:
        row: from 0 at the bottom.
        column: from 0 at the left.
        frame: number of frames of the episode executed by then, at least 1.
    """

    row: int
    column: int
    frame: int


@dataclass(frozen=True)
class EpisodeState:
    """A saved episode; the attributes are those of Episode."""

    console: ConsoleState
    start: Start
    actions: bytes
    hits: tuple[Hit, ...]
    end: EndReason | None
    shots: int
    lives: int
    missile_in_air: bool
    aliens: AlienGridState


class Episode:
    """One game on a console, whether played by a person, by an agent or replayed.

    Attributes:
        console: the console that the game runs on.
        start: how the game began.
        ending: which rule for the player's death ends it.
        max_frames: maximum length.
        end: why it ended, None while it goes on.
        shots: missiles that left the cannon.
    """

    def __init__(
        self,
        console: Console,
        start: Start,
        ending: Ending = Ending.HIT,
        max_frames: int = game.MAX_FRAMES,
    ) -> None:
        """Start the console and begin the episode.

        Raises:
            ValueError: max_frames is not positive.
        """
        if max_frames < 1:
            raise ValueError(f"Expected at least 1 frame, got {max_frames}.")
        self.console = console
        self.start = start
        self.ending = ending
        self.max_frames = max_frames
        self.end: EndReason | None = None
        self.shots = 0
        console.start(start)
        ram = console.ram_bytes()
        self._actions = bytearray()
        self._hits: list[Hit] = []
        self._lives = console.lives
        self._missile_in_air = missile_in_air(ram)
        self._grid = AlienGrid(ram)

    @property
    def frame(self) -> int:
        """Number of frames executed since the start."""
        return len(self._actions)

    @property
    def actions(self) -> bytes:
        """The action executed at every frame so far, one byte each."""
        return bytes(self._actions)

    @property
    def last_action(self) -> int:
        """The last executed action, NOOP at the start."""
        return self._actions[-1] if self._actions else game.Action.NOOP

    @property
    def hits(self) -> tuple[Hit, ...]:
        """The aliens shot so far, in order of time."""
        return tuple(self._hits)

    @property
    def aliens(self) -> npt.NDArray[np.bool_]:
        """The remaining aliens, bool (6, 6): row from the bottom, column from the left."""
        return self._grid.alive

    @property
    def shifts(self) -> int:
        """The absolute column of bit 0 of the RAM's alien rows."""
        return self._grid.shifts

    @property
    def formation(self) -> Formation:
        """The position of the grid on the screen: for pictures, never for learning."""
        return self._grid.formation(self.console.ram_bytes())

    def advance(self, action: int) -> None:
        """Run one frame with this action.

        Raises:
            EpisodeEnded: the episode is over.
            ValueError: there is no such action.
        """
        if self.end is not None:
            raise EpisodeEnded(f"The episode ended at frame {self.frame}: {self.end}.")
        if not 0 <= action < game.ACTION_COUNT:
            raise ValueError(f"Expected an action from 0 to {game.ACTION_COUNT - 1}, got {action}.")
        self.console.act(action)
        self._actions.append(action)
        ram = self.console.ram_bytes()
        for row, column in self._grid.update(ram):
            self._hits.append(Hit(row, column, self.frame))
        in_air = missile_in_air(ram)
        if in_air is not self._missile_in_air:
            self.shots += in_air
            self._missile_in_air = in_air
        if not in_play(ram) or len(self._actions) >= self.max_frames:
            self.end = self._end_reason(ram)

    def _end_reason(self, ram: bytes) -> EndReason | None:
        if self.ending is Ending.HIT and player_hit(ram):
            return EndReason.HIT
        if self.ending is Ending.LIFE_COUNTER and self.console.lives < self._lives:
            # Landing takes all lives at once.
            return EndReason.LANDED if landed(ram) else EndReason.LIVES
        if landed(ram):
            return EndReason.LANDED
        if cleared(ram):
            return EndReason.CLEARED
        if self.frame >= self.max_frames:
            return EndReason.STEPS
        return None

    def save(self) -> EpisodeState:
        """Return the state of the episode and its console."""
        return EpisodeState(
            console=self.console.save(),
            start=self.start,
            actions=self.actions,
            hits=self.hits,
            end=self.end,
            shots=self.shots,
            lives=self._lives,
            missile_in_air=self._missile_in_air,
            aliens=self._grid.save(),
        )

    def restore(self, state: EpisodeState) -> None:
        """Restore the state of this or another episode; ending and max_frames do not change."""
        self.console.restore(state.console)
        self.start = state.start
        self._actions = bytearray(state.actions)
        self._hits = list(state.hits)
        self.end = state.end
        self.shots = state.shots
        self._lives = state.lives
        self._missile_in_air = state.missile_in_air
        self._grid.restore(state.aliens)
