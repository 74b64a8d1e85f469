"""Matching of games to the plans that they fulfil."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tril.demonstrators import (
    DemonstrationPlan,
    GameOutcome,
    example_plans,
    match_plans,
    plan_violation,
)
from tril.demonstrators.space_invaders.plans import draw_hits
from tril.games.base import Cell
from tril.games.behaviours import Behaviour
from tril.games.space_invaders.behaviours import BUILT_IN, ROW_1
from tril.games.space_invaders.ends import EndReason
from tril.games.space_invaders.memory import MAX_FRAMES

ANYWHERE = frozenset((row, column) for row in range(6) for column in range(6))


def played(
    hits: Iterable[Cell], end: EndReason | None = EndReason.STEPS, n_frames: int = MAX_FRAMES
) -> GameOutcome:
    return GameOutcome(tuple(hits), end, n_frames)


@pytest.mark.parametrize("behaviour", BUILT_IN, ids=lambda behaviour: behaviour.slug)
def test_games_that_fulfil_all_plans_match_all_of_them(behaviour: Behaviour) -> None:
    plans = example_plans(behaviour)
    rng = np.random.default_rng(1)
    games = {100 + plan.number: played(draw_hits(plan, rng)) for plan in reversed(plans)}
    matched = match_plans(plans, games)
    assert list(matched) == [plan.number for plan in plans]
    assert set(matched.values()) == set(games)
    for plan in plans:
        assert plan_violation(plan, games[matched[plan.number] or 0]) is None


def test_row_1_out_of_order_is_not_a_perfect_sweep() -> None:
    plans = example_plans(ROW_1)
    sweep = [(0, column) for column in range(6)]
    assert match_plans(plans, {1: played(sweep)})[1] == 1
    assert match_plans(plans, {1: played(sweep[::-1])})[1] is None


def test_without_games_all_are_missing() -> None:
    plans = example_plans(BUILT_IN[0])
    assert set(match_plans(plans, {}).values()) == {None}
    # The game that hits nothing shows that nothing is hit, whatever else is missing.
    assert [n for n, game in match_plans(plans, {5: played([])}).items() if game] == [7]


@pytest.mark.parametrize(
    ("end", "n_frames"),
    [(None, 40), (None, MAX_FRAMES - 1), (EndReason.HIT, 700), (EndReason.LANDED, 1100)],
)
def test_a_game_that_was_not_survived_to_its_end_shows_nothing(
    end: EndReason | None, n_frames: int
) -> None:
    plans = example_plans(BUILT_IN[0])
    column = [(row, 0) for row in range(6)]
    games = {5: played([], end, n_frames), 6: played(column, end, n_frames)}
    assert set(match_plans(plans, games).values()) == {None}
    games |= {7: played([]), 8: played(column, EndReason.CLEARED, 900)}
    assert [game for game in match_plans(plans, games).values() if game] == [8, 7]


def _plan(number: int, min_hits: int, max_hits: int) -> DemonstrationPlan:
    return DemonstrationPlan(number, f"{min_hits} to {max_hits}", ANYWHERE, min_hits, max_hits)


def test_a_game_stands_for_one_plan_and_makes_way_for_another() -> None:
    cells: list[Cell] = [(0, column) for column in range(6)]
    plans = [_plan(1, 1, 4), _plan(2, 3, 3)]
    assert match_plans(plans, {10: played(cells[:3])}) == {1: 10, 2: None}
    assert match_plans(plans, {10: played(cells[:3]), 11: played(cells[:1])}) == {1: 11, 2: 10}


@given(
    st.lists(st.tuples(st.integers(0, 6), st.integers(0, 6)), max_size=6),
    st.lists(st.integers(0, 6), max_size=6),
)
def test_as_many_plans_as_possible_have_a_game_of_their_own(
    spans: list[tuple[int, int]], lengths: list[int]
) -> None:
    cells = [(row, 0) for row in range(6)]
    plans = [_plan(n, min(span), max(span)) for n, span in enumerate(spans)]
    matched = match_plans(
        plans, {100 + n: played(cells[:length]) for n, length in enumerate(lengths)}
    )
    used = [game for game in matched.values() if game is not None]
    assert len(used) == len(set(used))
    # Spans of lengths: taking the one that ends first for each length in order is best.
    free, best = sorted(lengths), 0
    for low, high in sorted((sorted(span) for span in spans), key=lambda span: span[1]):
        found = next((length for length in free if low <= length <= high), None)
        if found is not None:
            free.remove(found)
            best += 1
    assert len(used) == best
