"""Figures of evaluation games: means with intervals, and the winner of a start."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
import numpy.typing as npt

Numbers = npt.NDArray[np.float64]
Policy = Literal["imitator", "clone"]
Winner = Literal["imitator", "clone", "tie"]

RESAMPLES = 2000
RESAMPLING_SEED = 20
"""Fixed, so that the same games always give the same interval."""
_QUANTILE = 1.959964
"""Of the normal distribution at 97.5%."""


@dataclass(frozen=True)
class GameFigures:
    """The figures of one evaluation game.

    Attributes:
        targets: Target cells hit; None, as strays and order errors, for behaviours without target.
        strays: Hits outside the target.
        order_errors: Target hits out of order.
        steps: Length of the game.
        died: Whether the player died.
        predicted_return: Sum of R over its observations, if it was computed.
        n_targets: Number of target cells, where the game is to be judged as a whole.
    """

    targets: int | None
    strays: int | None
    order_errors: int | None
    steps: int
    died: bool
    predicted_return: float | None
    n_targets: int | None = None

    @property
    def perfect(self) -> bool | None:
        """Whether all targets were hit, in order, no other item was, and the player survived."""
        if self.targets is None or self.n_targets is None:
            return None
        flaws = (self.strays or 0) + (self.order_errors or 0) + self.died
        return self.targets == self.n_targets and not flaws


@dataclass(frozen=True)
class Interval:
    """A mean with its 95% interval over n games."""

    mean: float
    low: float
    high: float
    n: int


@dataclass(frozen=True)
class PolicySummary:
    """Means over a policy's games; None where games have no such number.

    ``perfect`` is the share of perfect games; runs of versions up to 0.2.0 have none stored.
    """

    targets: Interval | None
    strays: Interval | None
    order_errors: Interval | None
    steps: Interval
    death_rate: Interval
    predicted_return: Interval | None
    perfect: Interval | None = None


def interval(values: Sequence[float]) -> Interval:
    """Return the mean of values and its 95% interval by resampling them (percentile bootstrap).

    Raises:
        ValueError: There are no values.
    """
    if not values:
        raise ValueError("Expected at least one value.")
    numbers = np.asarray(values, np.float64)
    rng = np.random.default_rng(RESAMPLING_SEED)
    means = rng.choice(numbers, (RESAMPLES, len(numbers))).mean(1)
    low, high = np.percentile(means, [2.5, 97.5])
    return Interval(float(numbers.mean()), float(low), float(high), len(numbers))


def nested_interval(groups: Sequence[Sequence[float]]) -> Interval:
    """Return the mean of groups' means and its 95% interval by resampling groups and their values.

    So the interval of figures from several trainings holds what another training would change, and
    not only what other games would (Agarwal et al. 2021, section 4.1). Of one group it is
    ``interval``.

    Args:
        groups: The values of each training, none of them empty.

    Raises:
        ValueError: There are no values.
    """
    if len(groups) == 1:
        return interval(groups[0])
    means = np.stack([_resampled_means(values, seed) for seed, values in enumerate(groups)])
    rng = np.random.default_rng(RESAMPLING_SEED)
    drawn = rng.integers(len(groups), size=(len(groups), RESAMPLES))
    low, high = np.percentile(means[drawn, np.arange(RESAMPLES)].mean(0), [2.5, 97.5])
    mean = float(np.mean([np.mean(values) for values in groups]))
    return Interval(mean, float(low), float(high), sum(map(len, groups)))


def interquartile_interval(strata: Sequence[Sequence[Sequence[float]]]) -> Interval:
    """Return the interquartile mean of all groups' means, with its stratified 95% interval.

    The mean of the middle half, which neither a few failures nor a few perfect results decide
    (Agarwal et al. 2021, section 4.3). Groups are resampled within their stratum, and their values.

    Args:
        strata: For each behaviour the values of each training, none of them empty.

    Raises:
        ValueError: There are no values.
    """
    rng = np.random.default_rng(RESAMPLING_SEED)
    parts = []
    for number, groups in enumerate(strata):
        means = np.stack([_resampled_means(v, (number, seed)) for seed, v in enumerate(groups)])
        drawn = rng.integers(len(groups), size=(len(groups), RESAMPLES))
        parts.append(means[drawn, np.arange(RESAMPLES)])
    low, high = np.percentile(_interquartile_means(np.concatenate(parts)), [2.5, 97.5])
    group_means = np.array([[np.mean(values)] for groups in strata for values in groups])
    n = sum(len(values) for groups in strata for values in groups)
    return Interval(float(_interquartile_means(group_means)[0]), float(low), float(high), n)


def _resampled_means(values: Sequence[float], seed: int | tuple[int, int]) -> Numbers:
    """Return the means of resampled values, float64 (RESAMPLES,)."""
    if not values:
        raise ValueError("Expected at least one value.")
    rng = np.random.default_rng((RESAMPLING_SEED, *np.atleast_1d(seed).tolist()))
    means: Numbers = rng.choice(np.asarray(values, np.float64), (RESAMPLES, len(values))).mean(1)
    return means


def _interquartile_means(values: Numbers) -> Numbers:
    """Return the interquartile mean of each column of (N, K) values, float64 (K,).

    The quarters cut off count the values that they cut through in part.
    """
    n = len(values)
    ordered = np.sort(values, axis=0)
    begins = np.arange(n)
    inside = np.clip(np.minimum(begins + 1, 0.75 * n) - np.maximum(begins, 0.25 * n), 0.0, None)
    means: Numbers = inside @ ordered / inside.sum()
    return means


def proportion_interval(successes: float, n: int) -> Interval:
    """Return a proportion and its 95% interval by Wilson (1927), also of none or all of few.

    Args:
        successes: Number of successes; what counts half may be in it.
        n: Number of trials, at least 1.
    """
    share, spread = successes / n, _QUANTILE**2 / n
    centre = (share + spread / 2) / (1 + spread)
    half = (share * (1 - share) * spread + spread**2 / 4) ** 0.5 / (1 + spread)
    # It holds the share, which rounding would deny of none and of all.
    low, high = min(share, max(0.0, centre - half)), max(share, min(1.0, centre + half))
    return Interval(share, low, high, n)


def summarise(games: Sequence[GameFigures]) -> PolicySummary:
    """Return the means of a policy's games.

    Raises:
        ValueError: There are no games.
    """

    def mean_of(value: Callable[[GameFigures], float | None]) -> Interval | None:
        values = [number for game in games if (number := value(game)) is not None]
        return interval(values) if values else None

    return PolicySummary(
        targets=mean_of(lambda game: game.targets),
        strays=mean_of(lambda game: game.strays),
        order_errors=mean_of(lambda game: game.order_errors),
        steps=interval([game.steps for game in games]),
        death_rate=interval([float(game.died) for game in games]),
        predicted_return=mean_of(lambda game: game.predicted_return),
        perfect=mean_of(lambda game: game.perfect),
    )


def winner(imitator: GameFigures | None, clone: GameFigures | None) -> Winner | None:
    """Return the winner of a start: more targets hit, then fewer strays, then survival.

    In the thesis the death of the player does not count.

    Returns:
        None for behaviours without a target and where one of the two has not played.
    """
    if imitator is None or imitator.targets is None or clone is None or clone.targets is None:
        return None
    imitator_key = (imitator.targets, -(imitator.strays or 0), not imitator.died)
    clone_key = (clone.targets, -(clone.strays or 0), not clone.died)
    if imitator_key == clone_key:
        return "tie"
    return "imitator" if imitator_key > clone_key else "clone"
