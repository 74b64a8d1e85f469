"""Fragments of trajectories, which reward models are trained and checked on."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from tril.errors import Invalid
from tril.ranking import Pair, Ranking
from tril.recipes import RewardRecipe

Indices = npt.NDArray[np.int64]


@dataclass(frozen=True)
class FragmentPairs:
    """Pairs of equally long fragments, one of the better and one of the worse trajectory.

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
class Fragmenter:
    """Samples fragment pairs from pairs of trajectories.

    Attributes:
        min_length: Shortest fragment, in observations; a shorter trajectory is taken whole.
        max_length: Longest fragment, in observations, capped at the shorter trajectory of each
            pair. T-REX caps all pairs at the shortest trajectory of all, and fails where that is
            below ``min_length``.
        aligned: Whether both fragments start at the same step. Otherwise the better one starts no
            earlier than the worse one (T-REX, published code).
    """

    min_length: int
    max_length: int
    aligned: bool

    @classmethod
    def of(cls, recipe: RewardRecipe) -> Fragmenter:
        """Return the fragmenter of a recipe."""
        return cls(recipe.fragment_min_steps, recipe.fragment_max_steps, recipe.aligned)

    def sample(
        self,
        pairs: Sequence[Pair],
        sizes: Sequence[int],
        n_pairs: int,
        rng: np.random.Generator,
    ) -> FragmentPairs:
        """Sample preference pair, length and starts, each uniformly among those allowed.

        Args:
            pairs: Preference pairs of trajectory indices.
            sizes: Observations of each trajectory, at least 1.
            n_pairs: Fragment pairs to sample.
            rng: Source of randomness.
        """
        size = np.asarray(sizes, np.int64)
        better, worse = np.asarray(pairs, np.int64)[rng.integers(len(pairs), size=n_pairs)].T
        shorter = np.minimum(size[better], size[worse])
        shortest = np.minimum(self.min_length, shorter)
        longest = np.maximum(shortest, np.minimum(self.max_length, shorter))
        length = rng.integers(shortest, longest, endpoint=True)
        # A fragment of this length that starts there fits into both trajectories.
        worse_start = rng.integers(0, shorter - length, endpoint=True)
        better_start = worse_start
        if not self.aligned:
            better_start = rng.integers(worse_start, size[better] - length, endpoint=True)
        return FragmentPairs(better, worse, better_start, worse_start, length)


def preference_pairs(tiers: Sequence[Sequence[int]]) -> list[Pair]:
    """Return the pairs (better, worse) that tiers of trajectories imply; ties imply none.

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


def fragment_returns(
    rewards: npt.NDArray[np.float32], starts: Indices, lengths: Indices
) -> npt.NDArray[np.float64]:
    """Return the sums of ``rewards[start : start + length]``, float64 (P,), of one row (N,)."""
    sums = np.concatenate([[0.0], np.cumsum(rewards, dtype=np.float64)])
    return np.asarray(sums[starts + lengths] - sums[starts], np.float64)
