"""The draw and the result of a blind comparison."""

from __future__ import annotations

from itertools import chain

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tril.analysis.blind import (
    MAX_PAIRS,
    BlindAnswer,
    BlindPair,
    JudgedPair,
    blind_result,
    draw_pairs,
)
from tril.analysis.extrapolation import PlayerKind
from tril.analysis.summary import proportion_interval

RUN = "5d1f7b0e-7d2b-4bb0-9d0f-1b6f8d1b1a11"
STARTS = [(100 + start, 200 + start) for start in range(20)]
CLONES = dict(STARTS)
DEMONSTRATIONS = list(range(1, 13))


def test_a_round_is_drawn_the_same_each_time_and_another_round_and_run_differ() -> None:
    pairs = draw_pairs(RUN, 1, STARTS, DEMONSTRATIONS)
    assert draw_pairs(RUN, 1, STARTS, DEMONSTRATIONS) == pairs
    assert draw_pairs(RUN, 2, STARTS, DEMONSTRATIONS) != pairs
    assert draw_pairs(RUN.replace("5", "6"), 1, STARTS, DEMONSTRATIONS) != pairs


@given(st.integers(1, 500))
def test_a_round_is_balanced_between_opponents_and_sides(number: int) -> None:
    pairs = draw_pairs(RUN, number, STARTS, DEMONSTRATIONS)
    against_clone = [pair for pair in pairs if pair.other_id >= 200]
    assert (len(pairs), len(against_clone)) == (MAX_PAIRS, 5)
    assert all(pair.other_id == CLONES[pair.imitator_id] for pair in against_clone)
    assert sum(pair.imitator_left for pair in pairs) == 5
    assert sum(pair.imitator_left for pair in against_clone) in (2, 3)
    assert len(set(chain.from_iterable(pair.sides for pair in pairs))) == 2 * MAX_PAIRS


def test_the_order_of_pairs_tells_neither_the_opponent_nor_the_side() -> None:
    rounds = [draw_pairs(RUN, number, STARTS, DEMONSTRATIONS) for number in range(1, 401)]
    for place in range(MAX_PAIRS):
        clones = sum(pairs[place].other_id >= 200 for pairs in rounds) / len(rounds)
        left = sum(pairs[place].imitator_left for pairs in rounds) / len(rounds)
        # Four standard deviations of a fair draw.
        assert clones == pytest.approx(0.5, abs=0.1)
        assert left == pytest.approx(0.5, abs=0.1)


@pytest.mark.parametrize(
    ("n_starts", "n_demonstrations", "n_pairs"), [(0, 5, 0), (1, 9, 2), (3, 0, 3), (6, 2, 7)]
)
def test_few_games_make_fewer_pairs(n_starts: int, n_demonstrations: int, n_pairs: int) -> None:
    pairs = draw_pairs(RUN, 1, STARTS[:n_starts], DEMONSTRATIONS[:n_demonstrations])
    assert len(pairs) == n_pairs
    assert len({pair.other_id for pair in pairs}) == n_pairs


def judged(opponent: PlayerKind, answer: str, imitator_left: bool = True) -> JudgedPair:
    return JudgedPair(1, 2, imitator_left, 1, opponent, BlindAnswer(answer))


def test_the_sides_are_those_of_the_recordings() -> None:
    assert BlindPair(1, 2, imitator_left=True).sides == (1, 2)
    assert BlindPair(1, 2, imitator_left=False).sides == (2, 1)


def test_equal_pairs_count_half_and_sides_are_undone() -> None:
    result = blind_result(
        [
            [judged("clone", "left"), judged("clone", "left", imitator_left=False)],
            [],
            [judged("person", "right", imitator_left=False), judged("person", "equal")],
        ]
    )
    assert result is not None
    assert (result.wins, result.share.mean, result.share.n, result.n_people) == (2.5, 0.625, 4, 2)
    assert [(one.opponent, one.wins, one.n) for one in result.against] == [
        ("clone", 1.0, 2),
        ("person", 1.5, 2),
    ]
    assert "by 2 people" in result.sentence
    assert "2.5 of 4 pairs" in result.sentence
    assert blind_result([[]]) is None


def test_the_interval_is_wilsons() -> None:
    bounds = {7: (0.3968, 0.8922), 0: (0.0, 0.2775), 10: (0.7225, 1.0)}
    for wins, (low, high) in bounds.items():
        found = proportion_interval(wins, 10)
        assert found.low == pytest.approx(low, abs=1e-4)
        assert found.high == pytest.approx(high, abs=1e-4)
        assert 0 <= found.low <= found.mean <= found.high <= 1
