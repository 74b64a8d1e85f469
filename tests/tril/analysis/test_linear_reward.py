"""What a linear reward says of games, from pictures whose worth is planted."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tril.analysis.linear_reward import (
    MIN_GAMES_TO_CONTRADICT,
    Opinion,
    Picture,
    final_picture,
    form_opinions,
)
from tril.game.observation import OBSERVATION_SHAPE
from tril.ranking import Ranking, kendall_tau, normalise
from tril.recording import LEVEL_STEPS

N = 16


def pictures(n: int, seed: int = 0) -> dict[int, Picture]:
    """Return pictures by id from 100 on; each has one more dark row than the one before."""
    rng = np.random.default_rng(seed)
    made = rng.integers(0, 60, (n, 84, 84)).astype(np.uint8)
    for index, picture in enumerate(made):
        picture[10 : 70 - 60 * index // n, 20:50] += 150
    return {100 + index: picture for index, picture in enumerate(made)}


def in_order(items: list[int]) -> Ranking:
    return normalise([[item] for item in items])


def where(opinion: Opinion) -> tuple[float, float, float]:
    return opinion.place, opinion.best_place, opinion.worst_place


def test_a_final_picture_is_the_mean_of_the_last_newest_screens() -> None:
    observations = np.zeros((40, *OBSERVATION_SHAPE), np.uint8)
    observations[-LEVEL_STEPS:, -1] = 100
    observations[-1, -1] = 150
    observations[:, 0] = 255
    picture = final_picture(observations)
    assert picture.dtype == np.uint8
    assert np.unique(picture).tolist() == [102]


def test_it_orders_ranked_games_that_it_has_not_seen_and_further_ones() -> None:
    shown = pictures(3 * N)
    unseen, ranked = list(shown)[::3], [item for item in shown if item % 3 != 1]
    opinions = form_opinions(in_order(ranked), shown)
    assert opinions.keys() == shown.keys()
    places = {item: -opinion.place for item, opinion in opinions.items()}
    assert kendall_tau([[item] for item in ranked], places) > 0.9
    assert kendall_tau([[item] for item in unseen], places) > 0.9
    assert not any(opinion.contradicted_by for opinion in opinions.values())


def test_what_it_says_of_a_game_does_not_depend_on_where_that_is_ranked() -> None:
    shown = pictures(N)
    moved, *others = shown
    said = [
        form_opinions(in_order([*others[:at], moved, *others[at:]]), shown)[moved]
        for at in range(N)
    ]
    for opinion in said[1:]:
        assert where(opinion) == pytest.approx(where(said[0]), abs=1e-9)


def test_a_misplaced_game_is_contradicted_by_those_that_look_like_it() -> None:
    shown = pictures(N)
    best, *others = shown
    opinions = form_opinions(in_order([*others, best]), shown)
    assert opinions[best].tier <= 4
    assert opinions[best].contradicted_by
    assert set(opinions[best].contradicted_by) <= set(others[: N // 2])
    assert min(opinions, key=lambda item: opinions[item].p_value or 0.0) == best


def test_too_few_games_contradict_nobody() -> None:
    shown = pictures(MIN_GAMES_TO_CONTRADICT - 1)
    best, *others = shown
    opinions = form_opinions(in_order([*others, best]), shown)
    assert opinions[best].place < 0.5
    assert not any(opinion.contradicted_by for opinion in opinions.values())


def test_a_game_in_the_tier_that_is_expected_is_not_contradicted() -> None:
    shown = pictures(N)
    good, bad = tuple(shown)[:4], tuple(shown)[4:]
    opinions = form_opinions(Ranking((good, bad)), shown)
    for item, opinion in opinions.items():
        if opinion.tier == (1 if item in good else 2):
            assert not opinion.contradicted_by


@pytest.mark.parametrize("ranking", [Ranking(), in_order([100, 101, 102]), in_order([100])])
def test_too_small_a_ranking_says_nothing(ranking: Ranking) -> None:
    assert form_opinions(ranking, pictures(5)) == {}
    assert form_opinions(Ranking(((100, 101, 102, 103),)), pictures(5)) == {}


def test_a_game_whose_others_are_all_tied_could_be_anywhere() -> None:
    opinion = form_opinions(Ranking(((100,), (101, 102, 103))), pictures(4))[100]
    assert where(opinion) == pytest.approx((0.5, 0.159, 0.841), abs=1e-3)
    assert (opinion.best_tier, opinion.worst_tier) == (1, 2)


def test_games_that_look_the_same_are_placed_in_the_middle() -> None:
    picture = pictures(1)[100]
    opinions = form_opinions(in_order([1, 2, 3, 4, 5]), dict.fromkeys(range(1, 7), picture))
    assert opinions[6].place == pytest.approx(0.5, abs=0.01)
    assert all(
        0 <= best <= place <= worst <= 1 for place, best, worst in map(where, opinions.values())
    )


@given(st.lists(st.integers(0, 5), min_size=4, max_size=14), st.integers(0, 2**32 - 1))
@settings(max_examples=30, deadline=None)
def test_places_and_tiers_are_in_the_ranking_and_in_order(tier_of: list[int], seed: int) -> None:
    tiers: dict[int, list[int]] = {}
    for index, tier in enumerate(tier_of):
        tiers.setdefault(tier, []).append(100 + index)
    ranking = normalise(tiers.values())
    opinions = form_opinions(ranking, pictures(len(tier_of) + 2, seed))
    assert len(opinions) == (len(tier_of) + 2 if len(ranking.tiers) > 1 else 0)
    for opinion in opinions.values():
        assert 0 <= opinion.best_place <= opinion.place <= opinion.worst_place <= 1
        tiers_named = (1, opinion.best_tier, opinion.tier, opinion.worst_tier, len(ranking.tiers))
        assert list(tiers_named) == sorted(tiers_named)
        assert set(opinion.contradicted_by) <= set(ranking.items)
