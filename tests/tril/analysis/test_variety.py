"""Picking few items that are unlike each other."""

from __future__ import annotations

from collections import Counter

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from tril.analysis.variety import pick_evenly


@given(
    st.lists(st.tuples(st.integers(0, 3), st.integers(0, 2)), max_size=40),
    st.integers(0, 30),
    st.integers(0, 5),
)
def test_picked_items_are_distinct_and_as_many_as_possible(
    traits: list[tuple[int, int]], count: int, seed: int
) -> None:
    picked = pick_evenly(traits, count, np.random.default_rng(seed))
    assert len(picked) == min(count, len(traits))
    assert len(set(picked)) == len(picked)
    assert set(picked) <= set(range(len(traits)))


def test_a_common_kind_does_not_crowd_out_a_rare_one() -> None:
    traits = [("column-2", "person", 2)] * 50 + [
        (slug, source, length)
        for slug in ("column-2", "column-3", "own")
        for source in ("person", "scripted")
        for length in range(3)
    ]
    picked = pick_evenly(traits, 12, np.random.default_rng(0))
    for place, n_values in enumerate((3, 2, 3)):
        counts = Counter(traits[item][place] for item in picked)
        assert len(counts) == n_values
        assert max(counts.values()) - min(counts.values()) <= 2
    assert picked != pick_evenly(traits, 12, np.random.default_rng(1))
