"""A game whose actions a policy selects, advanced frame by frame. Pure."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from server.play.watch.messages import Actor
from tril.games.base import Console, Opening, Start, start_of
from tril.play.agent import (
    STICKY_ACTION_PROBABILITY,
    AgentGame,
    StickyActions,
    sample_actions,
)
from tril.play.episode import Episode
from tril.play.observation import Observation
from tril.play.vector.reset_distribution import FixedStarts
from tril.recording import Recording


class PolicyGame:
    """A game that a policy plays exactly as in an evaluation, but frame by frame.

    With the training seed of its run as ``seed`` it is the game of the run's evaluation.

    Args:
        console: The console to play on.
        actor: Actor of the game.
        beginning: Where the game begins; the policy plays from the end of an opening on.
        end_rule: Name of the rule by which a loss ends it.
        seed: Seeds sampled and repeated actions, together with the start.
    """

    def __init__(
        self,
        console: Console,
        actor: Actor,
        beginning: Start | Opening,
        end_rule: str,
        seed: int,
    ) -> None:
        self.actor = actor
        start = start_of(beginning)
        self._rng = np.random.default_rng((seed, *start.key))
        self._sticky = StickyActions(
            STICKY_ACTION_PROBABILITY if actor.action_selection == "sticky" else 0.0,
            np.random.default_rng((seed, *FixedStarts((start,)).rng_key(0), 1)),
        )
        self._game = AgentGame(console, end_rule)
        self._frames_per_step = console.game.clock.frames_per_step
        self._game.begin(beginning)
        self._action: int | None = None

    @property
    def episode(self) -> Episode:
        """The episode being played."""
        return self._game.episode

    @property
    def is_over(self) -> bool:
        """Whether the episode has ended."""
        return self._game.end is not None

    @property
    def at_boundary(self) -> bool:
        """Whether a step is complete, or none has begun."""
        return self.episode.frame % self._frames_per_step == 0

    @property
    def needs_action(self) -> bool:
        """Whether the next step's action is to be decided before the next frame."""
        return self._action is None and not self.is_over

    @property
    def observation(self) -> Observation:
        """The observation after the last step, uint8 (4, 84, 84), a fresh array."""
        return self._game.observation

    @property
    def observed_frame(self) -> int:
        """The frame that the observation is of."""
        frame = self.episode.frame
        return frame if self.is_over else frame - frame % self._frames_per_step

    def decide(self, probabilities: npt.NDArray[np.float32]) -> int:
        """Select the next step's action by its probabilities, float32 (n_actions,)."""
        if self.actor.action_selection == "sampled":
            quantile = np.array([self._rng.random()])
            self._action = int(sample_actions(probabilities[None], quantile)[0])
        else:
            self._action = int(probabilities.argmax())
        return self._action

    def advance(self) -> None:
        """Execute one frame.

        Raises:
            RuntimeError: The step's action has not been decided.
        """
        if self._action is None:
            raise RuntimeError("The step's action has not been decided.")
        self._game.advance(self._sticky.executed(self._action, self.episode.last_action))
        if self.at_boundary:
            self._action = None

    def recording(self) -> Recording:
        """Return the game so far, without hashes, which a verifying replay adds."""
        episode = self.episode
        return Recording(episode.game, episode.start, episode.actions, end_rule=episode.end_rule)
