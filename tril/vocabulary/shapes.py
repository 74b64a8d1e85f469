"""Shapes of statements: what of a group's facts a statement weighs.

"Below 60 px from the left" and "further to the left" are about the same facts, and say different
things of games that nobody has played yet. Each is a weighted sum of the group's facts with one
weight, which a few games can tell; weights that are free need many.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]

FREE_SHARE = 0.3
"""Prior probability that a statement about bins in order has a weight of its own for each."""
_TREND_SHARE = 0.2
"""That it rises or falls over the bins."""
_SIDE_SHARE = 0.25
"""That it is about all bins up to one, or from one on; the rest is about a range within."""
_ONLY_SHARE = 0.4
"""Of the statements about what is cleared, by place: that it is cleared there and nowhere else."""
_FREE_SHARE_UNORDERED = 0.5
"""The same as `FREE_SHARE` for facts without an order; the others are about a single fact."""


@dataclass(frozen=True, eq=False)
class Shapes:
    """Statements of one weight about a group.

    Attributes:
        sums: What each weighs, float64 (n_facts, n_shapes), 0 to 1, or -1 for what is not wanted.
        shares: Prior probability of each among the group's statements, float64 (n_shapes,).
        free_share: Prior probability of a weight for each fact; with the shares it adds up to 1.
        is_positive: Whether the weights are above 0, so that what is earned ends with the game. A
            range that is to be left is the range, or the side, where to be instead.
    """

    sums: Array
    shares: Array
    free_share: float
    is_positive: bool


_ONE_WAY_SHARE = 0.95
ONE_WAY = Shapes(np.eye(2), np.full(2, _ONE_WAY_SHARE / 2), 1 - _ONE_WAY_SHARE, is_positive=True)
"""One of two facts is wanted, such as one of two directions. Free weights remain possible for
games that show neither direction although a person means the group."""


@lru_cache
def shapes_of(n_facts: int, is_ordered: bool, excludes: bool = False) -> Shapes:
    """Return the shapes of statements about a group.

    Args:
        n_facts: Number of the group's facts.
        is_ordered: Whether they are bins in order.
        excludes: Whether what is true of some bins need not be false of others, so that it may be
            wanted in some and not in the others.
    """
    if n_facts == 1:
        return Shapes(np.zeros((1, 0)), np.zeros(0), 1.0, is_positive=is_ordered)
    if not is_ordered:
        shares = np.full(n_facts, (1 - _FREE_SHARE_UNORDERED) / n_facts)
        return Shapes(np.eye(n_facts), shares, _FREE_SHARE_UNORDERED, is_positive=False)
    rising = (np.arange(n_facts) + 0.5) / n_facts
    sides: list[Array] = []
    ranges: list[Array] = []
    for begin in range(n_facts):
        for end in range(begin + 1, n_facts + 1):
            within = np.zeros(n_facts)
            within[begin:end] = 1
            if end - begin < n_facts:
                (ranges if begin and end < n_facts else sides).append(within)
    range_share = 1 - FREE_SHARE - _TREND_SHARE - _SIDE_SHARE
    free_share = FREE_SHARE
    if not ranges:
        free_share, range_share = FREE_SHARE + range_share, 0.0
    shares = np.concatenate(
        [
            np.full(2, _TREND_SHARE / 2),
            np.full(len(sides), _SIDE_SHARE / len(sides)),
            np.full(len(ranges), range_share / max(len(ranges), 1)),
        ]
    )
    sums = np.stack([rising, 1 - rising, *sides, *ranges], 1)
    if excludes:
        # Of the sides, both ways are among them.
        parts = np.stack([*sides, *ranges, *(1 - one for one in ranges)], 1)
        only = 2 * parts - 1
        of_only = np.full(only.shape[1], _ONLY_SHARE / only.shape[1])
        shares = np.concatenate([(1 - _ONLY_SHARE) * shares, of_only])
        sums = np.concatenate([sums, only], 1)
        free_share *= 1 - _ONLY_SHARE
    return Shapes(sums, shares, free_share, is_positive=True)
