"""Which games contradict what was understood of their order."""

from __future__ import annotations

from server.understanding import Contradiction, strongest_contradiction

ORDER = [[1], [2, 3], [4]]


def test_the_games_that_are_furthest_the_wrong_way_round_are_named() -> None:
    values = {1: 0.0, 2: 3.0, 3: 1.0, 4: 2.0}
    assert strongest_contradiction(ORDER, values) == Contradiction(1, 2)


def test_games_that_are_nearly_alike_contradict_nothing() -> None:
    assert strongest_contradiction(ORDER, {1: 1.0, 2: 1.5, 3: 0.0, 4: 0.9}) is None
