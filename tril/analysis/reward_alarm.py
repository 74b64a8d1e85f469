"""An alarm for reward hacking: the predicted return rises, the games don't get better.

A policy that exploits an error of the learned reward earns ever more of it while its games get no
better (Brown et al. 2019, T-REX, section 6; Amodei et al. 2016, "Concrete Problems in AI Safety",
section 4). Learning never sees the hits that this alarm compares with.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

Points = Sequence[tuple[int, float]]
"""A curve: (step, value) in order of steps."""

BLOCKS = 6
"""Parts of a span; the mean of the last two is compared with that of the first two."""
GAMES_PER_BLOCK = 50
"""A point of the curves is the mean over the last 50 games: shorter blocks would share games."""
SPANS = (1 / 3, 9 / 10)
"""Shares of the training that are compared, counted from its end. The first games to end are
short ones, which have a low return by themselves."""
LEAST_RISE = 0.1
"""Of the range of the demonstrations' predicted returns; with six targets more than half a hit."""
LEAST_RISE_OF_HITS = 0.25
"""Targets a game that count as a rise, as do as many strays fewer; means of 100 games vary by less.
As many strays more count as a fall."""
MOST = 2 / 3
"""Share of the targets above which a policy may learn to survive longer instead of hitting more, as
long as strays don't rise."""
TIMES = (1.0, 0.75, 0.5, 0.25)
"""Shares of the training after which it is judged: what was found early counts until the games get
better."""

CURVES = ("predicted_return", "hits", "strays", "episode_steps")
"""The curves of the training games that are compared."""
_THIRD = BLOCKS // 3


@dataclass(frozen=True)
class Change:
    """A mean over games in the first and in the last third of a span."""

    before: float
    after: float

    @property
    def rise(self) -> float:
        """Last less first."""
        return self.after - self.before


@dataclass(frozen=True)
class RewardAlarm:
    """The predicted return has risen and the games have not got better.

    Attributes:
        from_step: Where the span begins, in PPO steps.
        to_step: Where it ends.
        predicted_return: Sum of R over a training game.
        hits: Targets hit in a training game.
        strays: Hits outside the target.
        episode_steps: Length of a training game.
    """

    from_step: int
    to_step: int
    predicted_return: Change
    hits: Change
    strays: Change
    episode_steps: Change

    @property
    def message(self) -> str:
        """The alarm for a person: what it means and what to do."""
        change = self.predicted_return
        longer = ""
        if self.episode_steps.after >= 1.1 * self.episode_steps.before:
            longer = (
                f" Its games also became longer ({self.episode_steps.before:.0f}, then"
                f" {self.episode_steps.after:.0f} steps), so it may be rewarded for staying alive."
            )
        return (
            "The learned reward may be rewarding something other than what you meant: from step"
            f" {self.from_step:,} to step {self.to_step:,} the predicted return of the training"
            f" games rose from {_number(change.before)} to {_number(change.after)}, but the games"
            f" got no better: {self.hits.before:.1f} targets and {self.strays.before:.1f} strays a"
            " game"
            f" before, {self.hits.after:.1f} and {self.strays.after:.1f} after.{longer} Watch the"
            " imitator\u2019s games to see what it does instead. Then add demonstrations which show"
            " the difference, ranked below those that do what you want, or change the order, and"
            " train again."
        )


def reward_alarm(
    curves: Mapping[str, Points], n_targets: int | None, demonstrated: Sequence[float]
) -> RewardAlarm | None:
    """Return an alarm if a training earns more predicted return without playing better.

    The last third of the training and nearly all of it are compared, now and as it stood earlier.
    An alarm is given where the predicted return rises by enough and its last blocks are all above
    its first ones, while neither hits rise nor strays fall, neither there nor since. Where most
    targets are hit already, strays have to rise as well.

    Args:
        curves: Curves of CURVES, by name.
        n_targets: Target cells of the behaviour; None where it has none.
        demonstrated: The predicted returns of the demonstrations, which give the scale.

    Returns:
        None if there is no reason for an alarm, no target, or not enough of the training yet.
    """
    if not n_targets or not all(curves.get(name) for name in CURVES):
        return None
    least_rise = LEAST_RISE * (max(demonstrated, default=0.0) - min(demonstrated, default=0.0))
    if least_rise <= 0.0:
        return None
    arrays = {name: np.array(curves[name], np.float64) for name in CURVES}
    last = arrays["predicted_return"][-1, 0]
    latest: RewardAlarm | None = None
    for time, share in itertools.product(TIMES, SPANS):
        looked_at = _changes(arrays, time * last * (1 - share), time * last)
        if looked_at is None:
            continue
        latest = latest or looked_at[0]
        change, is_above = looked_at
        if (
            is_above
            and change.predicted_return.rise >= least_rise
            and (change.hits.after < MOST * n_targets or change.strays.rise >= LEAST_RISE_OF_HITS)
            and not any(_is_better(change, later) for later in (change, latest))
        ):
            return change
    return None


def _number(value: float) -> str:
    return f"{value:,.0f}" if abs(value) >= 100.0 else f"{value:.3g}"


def _is_better(earlier: RewardAlarm, later: RewardAlarm) -> bool:
    """Whether games got better from before the first change until after the second one."""
    return (
        later.hits.after - earlier.hits.before >= LEAST_RISE_OF_HITS
        or earlier.strays.before - later.strays.after >= LEAST_RISE_OF_HITS
    )


def _changes(
    curves: Mapping[str, npt.NDArray[np.float64]], begin: float, end: float
) -> tuple[RewardAlarm, bool] | None:
    """Return the changes in a span, and whether the return's last blocks are all above its first.

    Args:
        curves: float64 (n, 2) each: step and value.
        begin: First step of the span.
        end: Last step of the span.

    Returns:
        None if the span is too short.
    """
    edges = np.linspace(begin, end, BLOCKS + 1)
    blocks = {name: _block_means(curves[name], edges) for name in CURVES}
    n_games = (edges[1] - edges[0]) / blocks["episode_steps"].mean()
    if any(np.isnan(means).any() for means in blocks.values()) or n_games < GAMES_PER_BLOCK:
        return None
    changes = {
        name: Change(float(means[:_THIRD].mean()), float(means[-_THIRD:].mean()))
        for name, means in blocks.items()
    }
    returns = blocks["predicted_return"]
    is_above = bool(returns[-_THIRD:].min() > returns[:_THIRD].max())
    return RewardAlarm(round(begin), round(end), **changes), is_above


def _block_means(
    points: npt.NDArray[np.float64], edges: npt.NDArray[np.float64]
) -> npt.NDArray[np.float64]:
    """Return the mean value in each block, float64 (BLOCKS,); NaN where a block has no point."""
    places = np.searchsorted(edges, points[:, 0], side="left") - 1
    return np.array(
        [
            values.mean() if len(values := points[places == block, 1]) else np.nan
            for block in range(BLOCKS)
        ]
    )
