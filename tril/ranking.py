"""Rankings: tiers, the preference pairs they imply, and the agreement of rankings."""

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

BEST_SHARE = 0.25
"""Share of the ranked recordings that stand in where none is marked as perfect."""


class Values(Protocol):
    """Values by recording: a mapping from id, or an array indexed by recording."""

    def __getitem__(self, item: int, /) -> float: ...


@dataclass(frozen=True)
class Ranking:
    """Recordings from best to worst, tied within a tier.

    Attributes:
        tiers: Ids of recordings, best tier first; tiers are disjoint and not empty.
    """

    tiers: tuple[tuple[int, ...], ...] = ()

    def __post_init__(self) -> None:
        """Check the tiers.

        Raises:
            Invalid: A tier is empty or a recording is ranked twice.
        """
        for place, tier in enumerate(self.tiers, start=1):
            if not tier:
                raise Invalid(f"Tier {place} is empty. Remove it or add a recording to it.")
        twice = [item for item, count in Counter(self.items).items() if count > 1]
        if twice:
            names = ", ".join(str(item) for item in sorted(twice))
            raise Invalid(f"A recording can be ranked only once; ranked twice: {names}.")

    @property
    def items(self) -> tuple[int, ...]:
        """All ranked recordings, best first."""
        return tuple(item for tier in self.tiers for item in tier)

    @property
    def n_pairs(self) -> int:
        """Number of preference pairs, computed without listing them."""
        sizes = [len(tier) for tier in self.tiers]
        return (sum(sizes) ** 2 - sum(size**2 for size in sizes)) // 2

    def pairs(self) -> list[Pair]:
        """Return the preference pairs (better, worse) of recordings in different tiers."""
        return [
            (better, worse)
            for above, below in combinations(self.tiers, 2)
            for better in above
            for worse in below
        ]

    def without(self, items: Collection[int]) -> Ranking:
        """Return the ranking without some recordings, dropping tiers that become empty."""
        return normalise((item for item in tier if item not in items) for tier in self.tiers)

    def with_restored(self, item: int, former: Ranking) -> Ranking:
        """Return the ranking with a recording restored to its place in a former ranking.

        It joins the first recording of its former tier that is still ranked. Otherwise it gets a
        tier of its own below the nearest former tier above it or, without any, above the nearest
        tier below.

        Args:
            item: The recording, which this ranking lacks.
            former: A ranking that holds it.

        Returns:
            The ranking as it is if it shares no recording with the earlier one, but holds others.
        """
        at = next(place for place, tier in enumerate(former.tiers) if item in tier)
        mates, tiers = former.tiers[at], [list(tier) for tier in self.tiers]
        place_of = {ranked_item: place for place, tier in enumerate(tiers) for ranked_item in tier}
        if tied := [mate for mate in mates if mate in place_of]:
            tier = tiers[place_of[tied[0]]]
            before = mates[: mates.index(item)]
            tier.insert(
                max((tier.index(mate) + 1 for mate in before if mate in tier), default=0), item
            )
            return normalise(tiers)
        for above in reversed(former.tiers[:at]):
            if places := [place_of[other_item] for other_item in above if other_item in place_of]:
                return normalise([*tiers[: max(places) + 1], [item], *tiers[max(places) + 1 :]])
        for below in former.tiers[at + 1 :]:
            if places := [place_of[other_item] for other_item in below if other_item in place_of]:
                return normalise([*tiers[: min(places)], [item], *tiers[min(places) :]])
        return self if tiers else normalise([[item]])

    def tier_numbers(self) -> dict[int, int]:
        """Return the tier of each recording, from 1 for the best."""
        return {item: place for place, tier in enumerate(self.tiers, start=1) for item in tier}


def normalise(tiers: Iterable[Iterable[int]]) -> Ranking:
    """Make a ranking from tiers, dropping empty ones.

    Raises:
        Invalid: A recording is ranked twice.
    """
    filled = (tuple(tier) for tier in tiers)
    return Ranking(tuple(tier for tier in filled if tier))


def best_ranked(tiers: Sequence[Sequence[int]], share: float = BEST_SHARE) -> list[int]:
    """Return the best of what is ranked: whole tiers from the top, at least one.

    Args:
        tiers: Ids or indices, best tier first.
        share: Further tiers are added as long as they fit into this share of all ids, and are in
            this share of the tiers, too: many bad games in one tier make no others good.
    """
    limit = share * sum(len(tier) for tier in tiers)
    best = list(tiers[0])
    for tier in tiers[1 : round(share * len(tiers))]:
        if len(best) + len(tier) > limit:
            break
        best += tier
    return best


def contradictions(first: Ranking, second: Ranking) -> list[Pair]:
    """Return the pairs (better, worse) of the first ranking that the second inverts."""
    place = second.tier_numbers()
    return [
        (better, worse)
        for better, worse in first.pairs()
        if better in place and worse in place and place[better] > place[worse]
    ]


def ranking_tau(first: Ranking, second: Ranking) -> float | None:
    """Return Kendall's tau-b of two rankings over the recordings that both rank, -1 to 1.

    None if either ranking has all of them in one tier.
    """
    first_place, second_place = first.tier_numbers(), second.tier_numbers()
    common = [item for item in first.items if item in second_place]
    return _tau_b([-first_place[item] for item in common], [-second_place[item] for item in common])


def kendall_tau(tiers: Sequence[Sequence[int]], values: Values) -> float:
    """Return Kendall's tau-b between a ranking and values of its recordings, -1 to 1.

    Args:
        tiers: Recordings (ids, or indices into ``values``), best tier first.
        values: A value for each, higher being better, such as the predicted return. If all are
            equal, the result is 0.

    Raises:
        Invalid: There are fewer than two tiers, or a value is not a number.
    """
    ranking = normalise(tiers)
    if len(ranking.tiers) < 2:
        raise Invalid("An order needs at least two tiers. Rank a better and a worse recording.")
    place = ranking.tier_numbers()
    numbers = [float(values[item]) for item in ranking.items]
    if np.isnan(numbers).any():
        raise Invalid("A value to compare with the ranking is not a number.")
    tau = _tau_b([-place[item] for item in ranking.items], numbers)
    return 0.0 if tau is None else tau


def _pair_signs(values: Sequence[float]) -> NDArray[np.int8]:
    """Return the sign of values[i] - values[j] for all i < j, int8 (n(n-1)/2,)."""
    array = np.asarray(values, dtype=np.float64)
    above, below = np.triu_indices(len(array), k=1)
    return (array[above] > array[below]).astype(np.int8) - (array[above] < array[below])


def _tau_b(first: Sequence[float], second: Sequence[float]) -> float | None:
    """Return Kendall's tau-b (Kendall 1945) of two sequences, None if either is constant."""
    first_signs, second_signs = _pair_signs(first), _pair_signs(second)
    untied = float(np.count_nonzero(first_signs)) * float(np.count_nonzero(second_signs))
    if untied == 0:
        return None
    return float(np.sum(first_signs * second_signs, dtype=np.int64) / np.sqrt(untied))
