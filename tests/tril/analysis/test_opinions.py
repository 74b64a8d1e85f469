"""What a ranking says of games, by what they hit."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tril.analysis import opinions as module
from tril.analysis.opinions import MIN_GAMES_TO_CONTRADICT, Opinion, Opinions, form_opinions
from tril.analysis.wanted_aliens import Hits
from tril.ranking import Ranking, kendall_tau, normalise

COLUMN_3 = [(row, 2) for row in range(6)]
STRAYS = [(0, 3), (0, 1), (1, 3), (1, 1), (2, 3), (0, 0)]


def game(n_targets: int, n_strays: int = 0) -> Hits:
    """Return what a game hits: the lowest aliens of column 3, and others."""
    hit = COLUMN_3[:n_targets] + STRAYS[:n_strays]
    return Hits.of([(row, column, 60 * at) for at, (row, column) in enumerate(hit, 1)], 1200)


def games() -> dict[int, Hits]:
    """Return thirteen games by id from 100 on, each a little worse than the one before."""
    made = [game(6 - missed) for missed in range(7)] + [game(0, strays) for strays in range(1, 7)]
    return dict(enumerate(made, 100))


def in_order(items: list[int]) -> Ranking:
    return normalise([[item] for item in items])


def say(ranking: Ranking, hits: dict[int, Hits], perfect: tuple[int, ...] = ()) -> Opinions:
    opinions = form_opinions(ranking, hits, perfect)
    assert opinions is not None
    return opinions


def where(opinion: Opinion) -> tuple[float, float, float]:
    return opinion.place, opinion.best_place, opinion.worst_place


def test_it_orders_ranked_games_without_their_own_word_and_further_ones() -> None:
    hits = games()
    further = {200 + index: game(index % 7, index // 7) for index in range(28)}
    opinions = say(in_order(list(hits)), hits | further)
    assert opinions.of.keys() == {*hits, *further}
    places = {item: -opinion.place for item, opinion in opinions.of.items()}
    assert kendall_tau([[item] for item in hits], places) > 0.9
    by_worth: dict[int, list[int]] = {}
    for index in range(28):
        by_worth.setdefault(index // 7 - index % 7, []).append(200 + index)
    assert kendall_tau([by_worth[key] for key in sorted(by_worth)], places) > 0.85
    assert not any(opinion.contradicted_by for opinion in opinions.of.values())
    assert all(opinions.of[item].p_value is None for item in further)


def test_it_says_which_aliens_the_order_asks_for() -> None:
    hits = games()
    opinions = say(in_order(list(hits)), hits)
    labels = opinions.labels.reshape(6, 6)
    assert (labels[:, 2] > 0.5).all(), labels
    assert (np.delete(labels, 2, 1) < 0).all(), labels
    assert not opinions.in_order.any()
    # The other way round, the third column is to be left alone.
    assert (say(in_order([*hits][::-1]), hits).labels.reshape(6, 6)[:, 2] < 0).all()


def test_perfect_games_say_what_is_wanted_as_well() -> None:
    hits = games() | {300 + index: game(6) for index in range(6)}
    few = in_order([103, 105, 107, 109])
    without, with_them = (say(few, hits, one) for one in ((), tuple(range(300, 306))))
    wanted = np.s_[5, 2]
    assert without.labels.reshape(6, 6)[wanted] < 0.5 < with_them.labels.reshape(6, 6)[wanted]


def test_games_that_sweep_a_row_teach_its_order() -> None:
    hits = {
        index: Hits.of([(0, at, 60 * (at + 1)) for at in range(6 - index)], 1200)
        for index in range(6)
    }
    best = {10 + index: hits[0] for index in range(8)}
    said = say(in_order(list(hits)), hits | best, tuple(best))
    assert (said.in_order[1:6] > 0.7).all()


def test_what_it_says_of_a_game_depends_little_on_where_that_is_ranked() -> None:
    hits = games()
    moved = 104
    others = [item for item in hits if item != moved]
    said = [
        say(in_order([*others[:at], moved, *others[at:]]), hits).of[moved].place
        for at in range(1, len(hits))
    ]
    assert max(said) - min(said) < 0.15, said


@pytest.mark.parametrize(("item", "to"), [(100, 12), (112, 0), (102, 10)])
def test_a_misplaced_game_is_contradicted_by_those_on_its_wrong_side(item: int, to: int) -> None:
    hits = games()
    others = [one for one in hits if one != item]
    opinions = say(in_order([*others[:to], item, *others[to:]]), hits).of
    assert opinions[item].contradicted_by
    # What is ranked best is thought to show what is wanted, even if it is the worst.
    near = sorted(others, key=lambda one: abs(one - item))[: 8 if to == 0 else 5]
    assert set(opinions[item].contradicted_by) <= set(near)
    # Of those that are ranked on the wrong side of it, by what it hits.
    assert all((one > item) == (to > item - 100) for one in opinions[item].contradicted_by)
    assert min(opinions, key=lambda one: opinions[one].p_value or 0.0) == item
    assert {one for one in opinions if opinions[one].contradicted_by} == {item}


def test_too_few_games_contradict_nobody() -> None:
    hits = dict(list(games().items())[: MIN_GAMES_TO_CONTRADICT - 1])
    best, *others = hits
    opinions = say(in_order([*others, best]), hits).of
    assert opinions[best].place < 0.5
    assert not any(opinion.contradicted_by for opinion in opinions.values())


def test_a_game_in_the_tier_that_is_expected_is_not_contradicted() -> None:
    hits = games()
    good, bad = tuple(hits)[:4], tuple(hits)[4:]
    for item, opinion in say(Ranking((good, bad)), hits).of.items():
        if opinion.tier == (1 if item in good else 2):
            assert not opinion.contradicted_by


@pytest.mark.parametrize(
    "ranking",
    [Ranking(), in_order([100, 101, 102]), in_order([100]), Ranking(((100, 101, 102, 103),))],
)
def test_too_small_a_ranking_says_nothing(ranking: Ranking) -> None:
    assert form_opinions(ranking, games()) is None


def test_games_that_hit_the_same_are_placed_in_the_middle() -> None:
    opinions = say(in_order([1, 2, 3, 4, 5]), dict.fromkeys(range(1, 7), game(2))).of
    assert opinions[6].place == pytest.approx(0.5, abs=0.01)
    assert all(
        0 <= best <= place <= worst <= 1 for place, best, worst in map(where, opinions.values())
    )


def test_of_many_pairs_some_say_what_all_would(monkeypatch: pytest.MonkeyPatch) -> None:
    rng = np.random.default_rng(1)
    hits = {index: game(*rng.integers(0, 7, 2).tolist()) for index in range(40)}
    ranking = in_order(sorted(hits, key=lambda one: hits[one].gone.reshape(6, 6)[:, 2].sum()))
    said = say(ranking, hits)
    monkeypatch.setattr(module, "_MAX_PAIRS", 300)
    fewer = say(ranking, hits)
    assert np.array_equal(said.labels > 0, fewer.labels > 0)
    assert all(abs(said.of[one].place - fewer.of[one].place) < 0.1 for one in hits)
    assert any(where(said.of[one]) != where(fewer.of[one]) for one in hits)


def test_a_huge_tier_of_bad_games_does_not_crowd_out_the_others() -> None:
    hits = games()
    bad = dict.fromkeys(range(1000, 1500), game(0, 6))
    asked = say(Ranking((*((one,) for one in hits), tuple(bad))), hits | bad)
    few = say(Ranking((*((one,) for one in hits), tuple(bad)[:2])), hits | bad)
    assert np.abs(asked.labels - few.labels).max() < 0.15


@given(
    st.lists(st.integers(0, 5), min_size=4, max_size=14),
    st.lists(st.tuples(st.integers(0, 6), st.integers(0, 6)), min_size=16, max_size=16),
)
@settings(max_examples=30)
def test_places_and_tiers_are_in_the_ranking_and_in_order(
    tier_of: list[int], hit: list[tuple[int, int]]
) -> None:
    tiers: dict[int, list[int]] = {}
    for index, tier in enumerate(tier_of):
        tiers.setdefault(tier, []).append(index)
    ranking = normalise(tiers.values())
    hits = {index: game(*one) for index, one in enumerate(hit)}
    opinions = form_opinions(ranking, hits, (15,))
    if len(ranking.tiers) < 2:
        assert opinions is None
        return
    assert opinions is not None
    assert opinions.of.keys() == hits.keys()
    assert (np.abs(opinions.labels) <= 1).all()
    for opinion in opinions.of.values():
        assert 0 <= opinion.best_place <= opinion.place <= opinion.worst_place <= 1
        tiers_named = (1, opinion.best_tier, opinion.tier, opinion.worst_tier, len(ranking.tiers))
        assert list(tiers_named) == sorted(tiers_named)
        assert set(opinion.contradicted_by) <= set(ranking.items)
