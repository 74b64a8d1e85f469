"""Fragments of ranked trajectories: what a reward model is trained and checked on."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
import numpy.typing as npt

from tril.errors import Invalid
from tril.ranking import Pair, Ranking
from tril.recipes import RewardRecipe

Indices = npt.NDArray[np.int64]

FragmentStarts = Literal["later", "same", "any"]
"""Where the fragments of a pair start: the better one no earlier than the worse one (T-REX,
published code), both at the same step, or each anywhere."""


@dataclass(frozen=True)
class FragmentPairs:
    """Pairs of equally long fragments, the first of each from the better trajectory.

    Attributes:
        better: Index of the better trajectory, int64 (P,).
        worse: Index of the worse trajectory, int64 (P,).
        better_start: First observation of the better fragment, int64 (P,).
        worse_start: First observation of the worse fragment, int64 (P,).
        length: Observations of each of the two, at least 1, int64 (P,).
    """

    better: Indices
    worse: Indices
    better_start: Indices
    worse_start: Indices
    length: Indices

    def __len__(self) -> int:
        """Return the number of pairs P."""
        return len(self.better)


@dataclass(frozen=True)
class FragmentRule:
    """Which fragments of two trajectories are compared.

    Attributes:
        shortest: Shortest fragment, in observations; a game that is shorter is taken whole.
        longest: Longest fragment, in observations, cut at the shorter game of each pair. T-REX
            cuts all pairs at the shortest game of all, and fails where that is below ``shortest``.
        starts: Where the two fragments start.
    """

    shortest: int
    longest: int
    starts: FragmentStarts

    @classmethod
    def of(cls, recipe: RewardRecipe) -> FragmentRule:
        """How a recipe compares ranked games, apart from the pairs that start freely."""
        starts: FragmentStarts = "same" if recipe.aligned else "later"
        return cls(recipe.fragment_min_steps, recipe.fragment_max_steps, starts)

    def every(self, stride: int) -> FragmentRule:
        """The same rule in units of every ``stride``-th observation."""
        return FragmentRule(
            max(1, self.shortest // stride), max(1, self.longest // stride), self.starts
        )


def preference_pairs(tiers: Sequence[Sequence[int]]) -> list[Pair]:
    """The pairs (better, worse) that tiers of trajectories imply; ties imply none.

    Raises:
        Invalid: There are fewer than two tiers.
    """
    pairs = Ranking(tuple(tuple(tier) for tier in tiers)).pairs()
    if not pairs:
        raise Invalid(
            "A reward is learned from what is better than what: rank demonstrations in at least"
            " two tiers."
        )
    return pairs


def draw_fragments(
    pairs: Sequence[Pair],
    n_observations: Sequence[int],
    rule: FragmentRule,
    count: int,
    rng: np.random.Generator,
    first: Sequence[int] | None = None,
) -> FragmentPairs:
    """Draw fragment pairs: preference pair, length and starts each evenly among those allowed.

    Args:
        pairs: Preference pairs of trajectory indices.
        n_observations: Where each trajectory's observations end: their number, at least 1, if they
            begin at 0.
        rule: Which fragments are compared.
        count: How many pairs are drawn.
        rng: Where the draws come from.
        first: Where each trajectory's observations begin; by default all at 0. Both fragments of a
            pair start where both trajectories have begun.
    """
    ends = np.asarray(n_observations, np.int64)
    begins = np.zeros_like(ends) if first is None else np.asarray(first, np.int64)
    chosen = np.asarray(pairs, np.int64)[rng.integers(len(pairs), size=count)]
    better, worse = chosen[:, 0], chosen[:, 1]
    begin = np.maximum(begins[better], begins[worse])
    shorter = np.minimum(ends[better], ends[worse]) - begin
    shortest = np.minimum(rule.shortest, shorter)
    longest = np.maximum(shortest, np.minimum(rule.longest, shorter))
    length = rng.integers(shortest, longest, endpoint=True)
    if rule.starts == "any":
        better_start = rng.integers(begin, ends[better] - length, endpoint=True)
        worse_start = rng.integers(begin, ends[worse] - length, endpoint=True)
        return FragmentPairs(better, worse, better_start, worse_start, length)
    # Never later in the worse game than a fragment of this length can still start in both.
    worse_start = rng.integers(begin, begin + shorter - length, endpoint=True)
    better_start = worse_start
    if rule.starts == "later":
        better_start = rng.integers(worse_start, ends[better] - length, endpoint=True)
    return FragmentPairs(better, worse, better_start, worse_start, length)


def fragment_sums(
    values: npt.NDArray[np.float32], starts: Indices, lengths: Indices
) -> npt.NDArray[np.float64]:
    """Return the sums of ``values[start : start + length]``, float64 (P,), of one row (N,)."""
    sums = np.concatenate([[0.0], np.cumsum(values, dtype=np.float64)])
    return np.asarray(sums[starts + lengths] - sums[starts], np.float64)
