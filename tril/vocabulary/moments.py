"""Moments that show a statement: seconds of a good game in which it holds most, of a bad one least.

Facts are kept as their means over whole seconds, which is enough to choose a few seconds by and a
fifteenth of what the steps have.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from tril.analysis.outcome import ShownMoment
from tril.games.base import Clock
from tril.vocabulary.kinds import Array
from tril.vocabulary.posterior import Tiers

MOMENT_S = 5
LEAST_DIFFERENCE = 1e-3
"""Difference of two moments' values, in log odds of a whole game, that is worth showing."""

Seconds = npt.NDArray[np.float16]
"""Mean facts of a game's whole seconds, float16 (n_seconds, n_facts)."""


@dataclass(frozen=True)
class Moment:
    """Successive seconds of a game.

    Attributes:
        game: Number of the game.
        second: The first second.
        n_seconds: How many; fewer than five only of a game that is shorter.
    """

    game: int
    second: int
    n_seconds: int

    def shown(self, recording_ids: Sequence[int], clock: Clock) -> ShownMoment:
        """Return the moment in frames.

        Args:
            recording_ids: Ids of the games, by their numbers.
            clock: The game's time.
        """
        per_second = steps_per_second(clock) * clock.frames_per_step
        return ShownMoment(
            recording_id=recording_ids[self.game],
            first_frame=self.second * per_second,
            n_frames=self.n_seconds * per_second,
        )


@dataclass(frozen=True)
class Contrast:
    """Two moments that differ in what a statement says.

    Attributes:
        most: Where it holds most.
        least: Where it holds least.
    """

    most: Moment
    least: Moment


def steps_per_second(clock: Clock) -> int:
    """Return the number of steps that count as a second."""
    return max(1, round(clock.frame_rate_hz / clock.frames_per_step))


def seconds_of(facts: Array, clock: Clock) -> Seconds:
    """Return the mean facts of each whole second of a game.

    Args:
        facts: Facts of every step, float32 (n_steps, n_facts).
        clock: The game's time.
    """
    per_second = steps_per_second(clock)
    n_seconds = min(len(facts), clock.max_steps) // per_second
    # (n_seconds, per_second, n_facts): the rest is less than a second.
    whole = facts[: n_seconds * per_second].reshape(n_seconds, per_second, facts.shape[1])
    means: Seconds = whole.mean(1).astype(np.float16)
    return means


def contrast(values: Sequence[npt.NDArray[np.floating]], tiers: Tiers) -> Contrast | None:
    """Choose the moments that show a statement best.

    Of the better half of the order that in which it holds most, of the worse half that in which it
    holds least. Where these do not differ so, they are chosen from all games.

    Args:
        values: The statement's value in each second of each game, (n_seconds,) each.
        tiers: Numbers of the ranked games, the best tier first.

    Returns:
        None if no two moments of the ranked games differ.
    """
    ranked = [game for tier in tiers for game in tier]
    middle = (len(ranked) + 1) // 2
    for better, worse in ((ranked[:middle], ranked[middle:]), (ranked, ranked)):
        # Of equal moments those of the best and of the worst game.
        most = max(_moments(values, better), key=lambda pair: pair[0], default=None)
        least = min(_moments(values, worse[::-1]), key=lambda pair: pair[0], default=None)
        if most and least and most[0] - least[0] >= LEAST_DIFFERENCE:
            return Contrast(most[1], least[1])
    return None


def _moments(
    values: Sequence[npt.NDArray[np.floating]], games: Sequence[int]
) -> list[tuple[float, Moment]]:
    """Return all moments of some games with their mean values."""
    moments: list[tuple[float, Moment]] = []
    for game in games:
        n_seconds = min(MOMENT_S, len(values[game]))
        if not n_seconds:
            continue
        sums = np.cumsum([0.0, *values[game]])
        means = (sums[n_seconds:] - sums[:-n_seconds]) / n_seconds
        moments += [
            (float(mean), Moment(game, second, n_seconds)) for second, mean in enumerate(means)
        ]
    return moments
