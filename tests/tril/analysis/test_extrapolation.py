"""How far what R predicts follows what games were worth."""

from __future__ import annotations

import pytest

from tril.analysis.extrapolation import JudgedGame, JudgedGames, true_quantity


def games(*points: tuple[int, float]) -> JudgedGames:
    made = tuple(JudgedGame(worth, value, number) for number, (worth, value) in enumerate(points))
    return JudgedGames("imitator", demonstrated=False, measure="final_level", games=made)


def test_strays_take_away_from_what_a_game_is_worth() -> None:
    assert true_quantity(6, 0) == 6
    assert true_quantity(2, 5) == -3


def test_tau_is_one_where_levels_follow_the_worth_and_minus_one_where_they_oppose_it() -> None:
    assert games((-1, 0.5), (3, 2.0), (0, 1.0)).tau == 1.0
    assert games((-1, 3.0), (3, -2.0), (0, 1.0)).tau == -1.0


def test_games_of_one_worth_are_ties() -> None:
    # Kendall's tau-b with one tie of three pairs: 2 / sqrt(2 * 3).
    assert games((1, 1.0), (1, 2.0), (2, 3.0)).tau == pytest.approx(0.8165, abs=1e-4)


def test_games_that_are_all_worth_the_same_have_no_order_to_agree_with() -> None:
    assert games((2, 1.0), (2, 3.0)).tau is None
    assert games().tau is None
