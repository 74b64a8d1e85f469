"""A game stepped by an agent: one action for all frames of a step."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from tril.games.base import Console, Opening, Start, Taken, start_of
from tril.play.episode import Episode, EpisodeState
from tril.play.observation import AgentView, AgentViewState, Observation

STICKY_ACTION_PROBABILITY = 0.25
"""Of the action selection "sticky" (Machado et al. 2018, section 5.1)."""


def sample_actions(
    probabilities: npt.NDArray[np.float32], quantiles: npt.NDArray[np.float64]
) -> npt.NDArray[np.int64]:
    """Return the action at a quantile of each distribution, int64 (N,).

    Args:
        probabilities: of each action, float32 (N, n_actions).
        quantiles: float64 (N,), 0 to 1; drawn uniformly, they sample the actions.
    """
    cumulative = probabilities.astype(np.float64).cumsum(1)
    sampled = (cumulative < quantiles[:, None] * cumulative[:, -1:]).sum(1)
    actions: npt.NDArray[np.int64] = np.minimum(sampled, probabilities.shape[1] - 1)
    return actions


class StickyActions:
    """Sticky actions: at every frame the previous frame's action may be repeated.

    This is the emulator's rule (Machado et al. 2018, "Revisiting the Arcade Learning Environment",
    section 5.1), drawn outside of it so that the executed actions can be recorded.

    Attributes:
        probability: of repeating the previous frame's action, 0 to 1.
        rng: source of the draws.
    """

    def __init__(self, probability: float, rng: np.random.Generator) -> None:
        """Check the probability."""
        if not 0.0 <= probability <= 1.0:
            raise ValueError(f"Expected a probability from 0 to 1, got {probability}.")
        self.probability = probability
        self.rng = rng

    def executed(self, chosen: int, before: int) -> int:
        """Return the action to execute, given the chosen one and the previous frame's."""
        if self.probability > 0.0 and self.rng.random() < self.probability:
            return before
        return chosen


@dataclass(frozen=True)
class AgentGameState:
    """A saved AgentGame between two steps; see Episode and AgentView."""

    episode: EpisodeState
    view: AgentViewState


class AgentGame:
    """An Episode stepped by agent steps, with its AgentView.

    An episode may end within a step; see AgentView.finish_step for its last observation.
    """

    def __init__(
        self,
        console: Console,
        end_rule: str | None = None,
        max_frames: int | None = None,
        sticky: StickyActions | None = None,
        view: AgentView | None = None,
    ) -> None:
        """Make a game on this console; call reset or restore to begin.

        Args:
            console: the console to play on.
            end_rule: name of the rule by which a loss ends an episode; None for the default.
            max_frames: maximum length of an episode; None for the game's.
            sticky: sticky actions, None for none.
            view: the view if it is one of AgentViews; None makes one.
        """
        self.console = console
        self.end_rule = end_rule
        self.max_frames = max_frames
        self.sticky = sticky
        self._episode: Episode | None = None
        self._view = AgentView(console.game) if view is None else view
        self._frames_per_step = console.game.clock.frames_per_step

    @property
    def episode(self) -> Episode:
        """The episode being played.

        Raises:
            RuntimeError: no episode has begun.
        """
        if self._episode is None:
            raise RuntimeError("No game has begun: call reset(start) first.")
        return self._episode

    def reset(self, start: Start) -> None:
        """Begin a game."""
        self._episode = Episode(self.console, start, self.end_rule, self.max_frames)
        self._view.reset(self.console)

    def begin(self, beginning: Start | Opening) -> int:
        """Begin a game and play its opening, if it has one; return the number of steps played.

        An opening that is not survived is left out.
        """
        self.reset(start_of(beginning))
        if not isinstance(beginning, Opening):
            return 0
        for action in beginning.actions:
            for _ in range(self._frames_per_step):
                self.advance(action)
                if self.end is not None:
                    self.reset(beginning.start)
                    return 0
        return len(beginning.actions)

    def step(self, action: int) -> None:
        """Execute the action for a step's frames, or until the episode ends.

        Raises:
            EpisodeEnded: the episode is over.
            ValueError: there is no such action.
        """
        episode, sticky = self.episode, self.sticky
        for _ in range(self._frames_per_step):
            executed = action if sticky is None else sticky.executed(action, episode.last_action)
            self._advance(episode, executed)
            if episode.end is not None:
                return

    def advance(self, action: int) -> None:
        """Execute one frame, for games with an action per frame.

        Raises:
            EpisodeEnded: the episode is over.
            ValueError: there is no such action.
        """
        self._advance(self.episode, action)

    def _advance(self, episode: Episode, action: int) -> None:
        episode.advance(action)
        self._view.update(self.console, episode.frame)
        if episode.end is not None:
            self._view.finish_step(self.console, episode.frame)

    @property
    def observation(self) -> Observation:
        """The observation after the last step, uint8 (4, 84, 84), a fresh array."""
        return self._view.observation

    def observe(self, out: Observation) -> None:
        """Write the observation into out, uint8 (4, 84, 84)."""
        self._view.observe(out)

    @property
    def steps(self) -> int:
        """Steps executed since the start, including one cut short by the end."""
        return self.console.game.clock.n_steps(self.episode.frame)

    @property
    def end(self) -> str | None:
        """Name of the end, None while the episode goes on."""
        return self.episode.end

    @property
    def taken(self) -> tuple[Taken, ...]:
        """The items taken so far, in order of time."""
        return self.episode.taken

    def save(self) -> AgentGameState:
        """Return the state of the game between two steps."""
        return AgentGameState(self.episode.save(), self._view.save())

    def restore(self, state: AgentGameState) -> None:
        """Restore a saved state; end rule, maximum length and sticky actions do not change."""
        if self._episode is None:
            self._episode = Episode(
                self.console, state.episode.start, self.end_rule, self.max_frames
            )
        self._episode.restore(state.episode)
        self._view.restore(state.view)
