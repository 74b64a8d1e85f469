"""Picking few items that are unlike each other."""

from __future__ import annotations

from collections import Counter
from collections.abc import Hashable, Sequence

import numpy as np

Traits = tuple[Hashable, ...]

N_PROPOSED = 8
"""Most games of an imitator that are proposed for a ranking at once."""


def pick_evenly(traits: Sequence[Traits], count: int, rng: np.random.Generator) -> list[int]:
    """Pick items so that each of their traits is spread evenly, and else at random.

    Args:
        traits: The traits of each item, as many of each.
        count: Number to pick, if there are as many.
        rng: Source of the choice among equals.

    Returns:
        Indices into ``traits``.
    """
    candidates = rng.permutation(len(traits)).tolist()
    n_picked: Counter[tuple[int, Hashable]] = Counter()
    picked = []
    for _ in range(min(count, len(traits))):
        best = min(
            candidates, key=lambda item: sum(n_picked[trait] for trait in enumerate(traits[item]))
        )
        candidates.remove(best)
        n_picked.update(enumerate(traits[best]))
        picked.append(best)
    return picked
