import math
from itertools import combinations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tril.errors import Invalid
from tril.ranking import (
    Ranking,
    best_ranked,
    contradictions,
    kendall_tau,
    normalise,
    ranking_tau,
)


@st.composite
def rankings(draw: st.DrawFn, min_items: int = 0) -> Ranking:
    items = draw(st.lists(st.integers(1, 60), unique=True, min_size=min_items, max_size=14))
    place = [draw(st.integers(0, 6)) for _ in items]
    return normalise(
        [item for item, at in zip(items, place, strict=True) if at == tier] for tier in range(7)
    )


@given(st.permutations(range(9)).flatmap(lambda p: st.integers(0, 9).map(lambda n: p[:n])))
def test_n_tiers_without_ties_give_all_pairs_in_order(items: list[int]) -> None:
    ranking = Ranking(tuple((item,) for item in items))
    pairs = ranking.pairs()
    n = len(items)
    assert len(pairs) == ranking.n_pairs == n * (n - 1) // 2
    assert all(items.index(better) < items.index(worse) for better, worse in pairs)


@given(rankings())
def test_each_two_recordings_of_different_tiers_give_one_pair_and_ties_none(
    ranking: Ranking,
) -> None:
    place = ranking.tier_numbers()
    pairs = ranking.pairs()
    assert len(pairs) == len(set(pairs)) == ranking.n_pairs
    assert {frozenset(pair) for pair in pairs} == {
        frozenset(two) for two in combinations(ranking.items, 2) if place[two[0]] != place[two[1]]
    }
    assert all(place[better] < place[worse] for better, worse in pairs)


def test_empty_tiers_are_dropped_by_normalise_and_refused_by_ranking() -> None:
    assert normalise([[], [3, 1], [], [2]]) == Ranking(((3, 1), (2,)))
    with pytest.raises(Invalid, match="Tier 2 is empty"):
        Ranking(((1,), ()))


def test_a_recording_has_only_one_place() -> None:
    with pytest.raises(Invalid, match="twice: 4"):
        normalise([[4, 5], [4]])
    with pytest.raises(Invalid, match="twice: 4"):
        normalise([[4, 4]])


def test_removing_recordings_drops_empty_tiers() -> None:
    assert Ranking(((1,), (2, 3), (4,))).without({1, 3}) == Ranking(((2,), (4,)))


@given(rankings(min_items=1), st.data())
def test_a_recording_that_was_taken_out_comes_back_where_it_was(
    ranking: Ranking, data: st.DataObject
) -> None:
    item = data.draw(st.sampled_from(ranking.items))
    assert ranking.without({item}).with_restored(item, ranking) == ranking


def test_a_recording_comes_back_beside_what_is_still_ranked() -> None:
    former = Ranking(((1,), (2, 3), (4,), (5,)))
    assert Ranking(((5,), (3,), (1,))).with_restored(2, former).tiers == ((5,), (2, 3), (1,))
    # Its tier is gone: between its neighbours, or beside the one that is left.
    assert Ranking(((1, 9), (5,), (8,))).with_restored(4, former).tiers == (
        (1, 9),
        (4,),
        (5,),
        (8,),
    )
    assert Ranking(((9,), (5,))).with_restored(2, former).tiers == ((9,), (2,), (5,))
    assert Ranking(((9,), (1,), (8,))).with_restored(2, former).tiers == ((9,), (1,), (2,), (8,))
    assert Ranking().with_restored(2, former).tiers == ((2,),)
    unrelated = Ranking(((8,), (9,)))
    assert unrelated.with_restored(2, former) == unrelated


@given(rankings(), rankings())
def test_contradictions_are_the_pairs_ordered_the_other_way_round(
    first: Ranking, second: Ranking
) -> None:
    found = contradictions(first, second)
    assert {(worse, better) for better, worse in found} == set(contradictions(second, first))
    common = set(first.items) & set(second.items)
    inverted = [
        pair for pair in first.pairs() if common.issuperset(pair) and pair[::-1] in second.pairs()
    ]
    assert sorted(found) == sorted(inverted)


@given(rankings(), rankings())
def test_tau_of_two_rankings_is_of_what_both_rank(first: Ranking, second: Ranking) -> None:
    above, below = first.tier_numbers(), second.tier_numbers()
    common = [item for item in first.items if item in below]
    tau = ranking_tau(first, second)
    expected = _tau_by_counting(
        [-float(above[item]) for item in common], [-float(below[item]) for item in common]
    )
    assert (tau or 0.0) == pytest.approx(expected)
    one_tier = any(len({place[item] for item in common}) < 2 for place in (above, below))
    assert (tau is None) == one_tier


@given(rankings())
def test_a_ranking_agrees_with_itself(ranking: Ranking) -> None:
    assert contradictions(ranking, ranking) == []
    assert ranking_tau(ranking, ranking) == (1 if len(ranking.tiers) > 1 else None)


def _tau_by_counting(one: list[float], other: list[float]) -> float:
    concordant = discordant = tied_one = tied_other = 0
    for i, j in combinations(range(len(one)), 2):
        a, b = one[i] - one[j], other[i] - other[j]
        concordant += a * b > 0
        discordant += a * b < 0
        tied_one += a == 0
        tied_other += b == 0
    n_pairs = len(one) * (len(one) - 1) // 2
    scale = math.sqrt((n_pairs - tied_one) * (n_pairs - tied_other))
    return (concordant - discordant) / scale if scale else 0.0


@given(rankings(min_items=2), st.data())
def test_tau_is_the_textbooks_tau_b(ranking: Ranking, data: st.DataObject) -> None:
    if len(ranking.tiers) < 2:
        return
    values = {item: data.draw(st.integers(-3, 3)) for item in ranking.items}
    place = ranking.tier_numbers()
    expected = _tau_by_counting(
        [-float(place[item]) for item in ranking.items],
        [float(values[item]) for item in ranking.items],
    )
    assert kendall_tau(ranking.tiers, values) == pytest.approx(expected)


def test_tau_takes_indices_into_an_array() -> None:
    assert kendall_tau([[2], [0, 1]], np.array([1.0, 0.5, 7.0])) > 0.8
    assert kendall_tau([[2], [0], [1]], np.array([1.0, 7.0, 0.5])) == -1


def test_tau_of_equal_values_is_nothing() -> None:
    assert kendall_tau([[0], [1]], [3.0, 3.0]) == 0


def test_tau_needs_two_tiers_and_numbers() -> None:
    with pytest.raises(Invalid, match="at least two tiers"):
        kendall_tau([[0, 1]], [1.0, 2.0])
    with pytest.raises(Invalid, match="not a number"):
        kendall_tau([[0], [1]], [1.0, math.nan])


def test_the_best_ranked_are_whole_tiers_from_the_top() -> None:
    tiers = [[3], [1, 2], [0], [4, 5, 6, 7]]
    assert best_ranked(tiers, 0.0) == [3]
    assert best_ranked(tiers, 0.3) == [3]
    assert best_ranked(tiers, 0.4) == [3, 1, 2]
    assert best_ranked(tiers, 1.0) == [3, 1, 2, 0, 4, 5, 6, 7]


def test_many_games_in_the_last_tier_make_no_others_good() -> None:
    ranked = [[index] for index in range(7)]
    assert best_ranked([*ranked, [7]]) == [0, 1]
    assert best_ranked([*ranked, list(range(10, 50))]) == [0, 1]
