"""An episode: one game on a console from its start to its end."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from tril.errors import Conflict
from tril.games.base import Console, ConsoleState, Game, Readout, Start, Taken


class EpisodeEnded(Conflict):
    """The episode is over."""


@dataclass(frozen=True)
class EpisodeState:
    """A saved episode; the attributes are those of Episode and its readout."""

    console: ConsoleState
    start: Start
    actions: bytes
    taken: tuple[Taken, ...]
    end: str | None
    counters: dict[str, int]
    readout: dict[str, Any]


class Episode:
    """One game on a console, whether played by a person, by an agent or replayed.

    Attributes:
        console: the console that the game runs on.
        game: the game.
        start: how the game began.
        end_rule: name of the rule by which a loss ends it.
        max_frames: maximum length.
        end: name of the end, None while it goes on.
        readout: what is read of it.
    """

    def __init__(
        self,
        console: Console,
        start: Start,
        end_rule: str | None = None,
        max_frames: int | None = None,
    ) -> None:
        """Start the console and begin the episode.

        Args:
            console: the console to play on.
            start: how the game begins.
            end_rule: name of the rule by which a loss ends it; None for the game's default.
            max_frames: maximum length; None for the game's.

        Raises:
            ValueError: max_frames is not positive.
            Invalid: there is no such end rule.
        """
        self.console = console
        self.game: Game = console.game
        self.start = start
        self.end_rule = self.game.check_end_rule(end_rule or self.game.end_rule)
        self.max_frames = self.game.clock.max_frames if max_frames is None else max_frames
        if self.max_frames < 1:
            raise ValueError(f"Expected at least 1 frame, got {max_frames}.")
        self.end: str | None = None
        console.start(start)
        self.readout: Readout = self.game.new_readout(console, self.end_rule)
        self._actions = bytearray()
        self._n_actions = self.game.controls.n_actions

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
        """The last executed action, the neutral one at the start."""
        return self._actions[-1] if self._actions else self.game.controls.noop

    @property
    def taken(self) -> tuple[Taken, ...]:
        """The items taken so far, in order of time."""
        return tuple(self.readout.taken)

    @property
    def counters(self) -> dict[str, int]:
        """Counts since the start, by name."""
        return dict(self.readout.counters)

    @property
    def score(self) -> float:
        """Rewards of the game itself since the start; never seen by learning."""
        return self.console.score

    @property
    def died(self) -> bool:
        """Whether it ended with the player's death."""
        return self.game.is_death(self.end)

    def advance(self, action: int) -> None:
        """Run one frame with this action.

        Raises:
            EpisodeEnded: the episode is over.
            ValueError: there is no such action.
        """
        if self.end is not None:
            raise EpisodeEnded(f"The episode ended at frame {self.frame}: {self.end}.")
        if not 0 <= action < self._n_actions:
            raise ValueError(f"Expected an action from 0 to {self._n_actions - 1}, got {action}.")
        self.console.act(action)
        self._actions.append(action)
        self.end = self.readout.update(self.console, len(self._actions))
        if self.end is None and len(self._actions) >= self.max_frames:
            self.end = self.game.time_end

    def save(self) -> EpisodeState:
        """Return the state of the episode and its console.

        Raises:
            Invalid: the game does not save states.
        """
        return EpisodeState(
            console=self.console.save(),
            start=self.start,
            actions=self.actions,
            taken=self.taken,
            end=self.end,
            counters=self.counters,
            readout=self.readout.save(),
        )

    def restore(self, state: EpisodeState) -> None:
        """Restore the state of this or another episode; end rule and max_frames do not change."""
        self.console.restore(state.console)
        self.start = state.start
        self._actions = bytearray(state.actions)
        self.end = state.end
        self.readout.taken = list(state.taken)
        self.readout.counters = dict(state.counters)
        self.readout.restore(state.readout)
