"""Rankings as pure data: tiers, the preference pairs they imply, and how far rankings agree."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from tril.errors import Invalid

Pair = tuple[int, int]
"""(better, worse): a preference between two recordings."""


class Values(Protocol):
    """Numbers by recording: a mapping from id, or an array where the recordings are indices."""

    def __getitem__(self, item: int, /) -> float: ...


@dataclass(frozen=True)
class Ranking:
    """Recordings from best to worst; those in one tier are tied.

    Attributes:
        tiers: Ids of recordings, best tier first; no tier is empty, no recording in two places.
    """

    tiers: tuple[tuple[int, ...], ...] = ()

    def __post_init__(self) -> None:
        """Check the tiers.

        Raises:
            Invalid: A tier is empty or a recording is ranked twice.
        """
        for place, tier in enumerate(self.tiers, start=1):
            if not tier:
                raise Invalid(f"Tier {place} is empty; leave it out or put a recording into it.")
        twice = [item for item, count in Counter(self.items).items() if count > 1]
        if twice:
            names = ", ".join(str(item) for item in sorted(twice))
            raise Invalid(f"Each recording has one place in a ranking, got twice: {names}.")

    @property
    def items(self) -> tuple[int, ...]:
        """All ranked recordings, best first."""
        return tuple(item for tier in self.tiers for item in tier)

    @property
    def n_pairs(self) -> int:
        """The number of preference pairs, without listing them."""
        sizes = [len(tier) for tier in self.tiers]
        return (sum(sizes) ** 2 - sum(size**2 for size in sizes)) // 2

    def pairs(self) -> list[Pair]:
        """The preference pairs (better, worse): each two recordings of different tiers once.

        n tiers of one recording each give n(n-1)/2 pairs; tied recordings give none.
        """
        return [
            (better, worse)
            for above, below in combinations(self.tiers, 2)
            for better in above
            for worse in below
        ]

    def without(self, items: Collection[int]) -> Ranking:
        """This ranking with some recordings taken out, and the tiers that this empties."""
        return normalise((item for item in tier if item not in items) for tier in self.tiers)

    def tier_numbers(self) -> dict[int, int]:
        """The tier of each recording, counted from 1 for the best."""
        return {item: place for place, tier in enumerate(self.tiers, start=1) for item in tier}


@dataclass(frozen=True)
class Agreement:
    """How two rankings of partly the same recordings compare.

    Attributes:
        n_common: Recordings that both rank.
        concordant: Pairs that both order alike.
        discordant: Pairs that they order the other way round.
        tied: Pairs that at least one of them ties.
        tau: Kendall's tau-b over the common recordings, -1 to 1; None where it is undefined,
            because either ranking has all of them in one tier.
    """

    n_common: int
    concordant: int
    discordant: int
    tied: int
    tau: float | None


def normalise(tiers: Iterable[Iterable[int]]) -> Ranking:
    """Make a ranking of tiers as they come from a person: empty tiers are dropped.

    Raises:
        Invalid: A recording is ranked twice.
    """
    filled = (tuple(tier) for tier in tiers)
    return Ranking(tuple(tier for tier in filled if tier))


def contradictions(first: Ranking, second: Ranking) -> list[Pair]:
    """The pairs (better, worse) of the first ranking that the second orders the other way."""
    place = second.tier_numbers()
    return [
        (better, worse)
        for better, worse in first.pairs()
        if better in place and worse in place and place[better] > place[worse]
    ]


def agreement(first: Ranking, second: Ranking) -> Agreement:
    """Compare two rankings over the recordings that both of them rank."""
    first_place, second_place = first.tier_numbers(), second.tier_numbers()
    common = [item for item in first.items if item in second_place]
    signs = _pair_signs([-first_place[item] for item in common])
    products = signs * _pair_signs([-second_place[item] for item in common])
    return Agreement(
        n_common=len(common),
        concordant=int((products > 0).sum()),
        discordant=int((products < 0).sum()),
        tied=int((products == 0).sum()),
        tau=_tau_b(
            [-first_place[item] for item in common], [-second_place[item] for item in common]
        ),
    )


def kendall_tau(tiers: Sequence[Sequence[int]], values: Values) -> float:
    """Kendall's tau-b between a ranking and a number for each of its recordings.

    Args:
        tiers: Recordings (ids, or indices into ``values``), best tier first.
        values: A number for each, higher meaning better, such as the predicted return.

    Returns:
        1 where the values order the recordings as the tiers do, -1 where the other way round; 0
        where all values are equal, since these say nothing about the order.

    Raises:
        Invalid: There are fewer than two tiers, or a value is not a number.
    """
    ranking = normalise(tiers)
    if len(ranking.tiers) < 2:
        raise Invalid("An order needs at least two tiers; rank a better and a worse recording.")
    place = ranking.tier_numbers()
    numbers = [float(values[item]) for item in ranking.items]
    if np.isnan(numbers).any():
        raise Invalid("A value to compare the ranking with is not a number.")
    tau = _tau_b([-place[item] for item in ranking.items], numbers)
    return 0.0 if tau is None else tau


def _pair_signs(values: Sequence[float]) -> NDArray[np.int8]:
    """Compare all i < j: int8 (n(n-1)/2,), 1 where the first of the two is higher, -1 lower."""
    array = np.asarray(values, dtype=np.float64)
    above, below = np.triu_indices(len(array), k=1)
    return (array[above] > array[below]).astype(np.int8) - (array[above] < array[below])


def _tau_b(first: Sequence[float], second: Sequence[float]) -> float | None:
    """Kendall's tau-b (Kendall 1945) of two equally long rows, None where either is constant."""
    one, other = _pair_signs(first), _pair_signs(second)
    untied = float(np.count_nonzero(one)) * float(np.count_nonzero(other))
    if untied == 0:
        return None
    return float(np.sum(one * other, dtype=np.int64) / np.sqrt(untied))
