"""Measures as data, and their values in games."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tril.errors import Invalid
from tril.games import game_named
from tril.games.base import Taken
from tril.games.behaviours import Behaviour
from tril.games.measures import (
    ActionRate,
    AliveAtEnd,
    Axes,
    Counted,
    GameScore,
    InRegion,
    ItemsInOrder,
    ItemsTaken,
    Length,
    Measure,
    Near,
    Per,
    Unit,
    measure_from_json,
    measures_from_json,
)
from tril.games.measuring import Played, check_measures, measure, measured_before
from tril.games.settings import Rectangle
from tril.recording import Recording, verify

PONG = game_named("pong")
SPACE_INVADERS = game_named("space_invaders")

ROWS = ((tuple((row, column) for column in range(6)) for row in range(6)),)
EVERY_KIND: tuple[Measure, ...] = (
    ItemsTaken(cells=((0, 0), (1, 5)), at_least=2),
    ItemsTaken(at_most=12),
    ItemsInOrder(sequences=tuple(map(tuple, ROWS)), at_least=0.9),
    InRegion(thing="cannon", area=Rectangle(0, 25, 80, 210), at_least=0.9),
    Near(thing="cannon", other="missile", distance_px=12, axes=Axes.X, at_most=0.5),
    ActionRate(button="fire", at_most=2),
    ActionRate(action="LEFT", per=Per.TIME, at_least=0.1, at_most=0.5),
    GameScore(at_least=100),
    AliveAtEnd(),
    Length(at_least=10),
    Counted(counter="shots", at_most=12),
)


def played(**changes: object) -> Played:
    game = Played(np.zeros((1, 128), np.uint8), b"", (), {}, 0, None)
    return replace(game, **changes)  # type: ignore[arg-type]


def value(one: Measure, game: Played, name: str = "space_invaders") -> float | None:
    (found,) = measure(game_named(name), [one], game)
    return found.value


def pong(ys: list[int], ball_ys: list[int] | None = None) -> Played:
    """Return a game of Pong with the player's paddle, and the ball, at these bytes."""
    memory = np.zeros((len(ys), 128), np.uint8)
    memory[:, 51] = ys
    memory[:, 54] = ball_ys or 0
    return played(memory=memory, actions=bytes(len(ys) - 1))


@pytest.mark.parametrize("one", EVERY_KIND)
def test_a_measure_is_the_same_after_it_was_written_and_read(one: Measure) -> None:
    read = measure_from_json(json.loads(json.dumps(one.to_json())))
    assert read == one
    assert read.key == one.key


def test_every_kind_can_be_measured_in_space_invaders() -> None:
    check_measures(SPACE_INVADERS, EVERY_KIND)
    start = SPACE_INVADERS.starts.training[0]
    fires = SPACE_INVADERS.controls.actions.index("FIRE")
    recording = Recording(SPACE_INVADERS, start, bytes([fires] * 300))
    outcome = verify(recording, measures=EVERY_KIND).replay
    assert set(outcome.measured) == {one.key for one in EVERY_KIND}
    by_kind = {one.kind: outcome.measured[one.key] for one in EVERY_KIND}
    assert by_kind["counter"] == outcome.counters["shots"] > 0
    assert by_kind["length"] == outcome.n_frames / 60
    assert by_kind["score"] == outcome.score
    # The cannon stands at the left wall.
    assert by_kind["region"] == 1


def test_a_bound_does_not_change_what_is_stored() -> None:
    keys = {Length(at_least=low).key for low in (None, 3, 10)}
    assert len(keys) == 1
    assert Length().key != GameScore().key
    assert Counted(counter="shots").key != Counted(counter="divers").key


@given(st.floats(0, 1), st.floats(0, 1), st.floats(0, 1))
def test_a_value_meets_bounds_that_it_lies_between(a: float, b: float, c: float) -> None:
    low, middle, high = sorted((a, b, c))
    one = InRegion(thing="ball", area=Rectangle(0, 0, 1, 1), at_least=low, at_most=high)
    assert one.is_met(middle)
    assert one.is_met(low - 0.1) is False
    assert one.is_met(high + 0.1) is False
    assert one.is_met(None) is None


def test_without_a_bound_nothing_is_met_or_missed() -> None:
    assert Length().is_met(3) is None


def test_items_are_counted_all_or_those_that_are_named() -> None:
    taken = tuple(Taken(row, column, 5) for row, column in [(0, 0), (0, 1), (1, 5)])
    assert value(ItemsTaken(), played(taken=taken)) == 3
    assert value(ItemsTaken(cells=((0, 0), (1, 5), (2, 2))), played(taken=taken)) == 2


SIDES = ItemsInOrder(
    sequences=(
        tuple(tuple((row, column) for row in range(6)) for column in (0, 1, 2)),
        tuple(tuple((row, column) for row in range(6)) for column in (5, 4, 3)),
    )
)


def in_order(*cells: tuple[int, int]) -> float | None:
    taken = tuple(Taken(*cell, frame=n) for n, cell in enumerate(cells, start=1))
    return value(SIDES, played(taken=taken))


def test_an_item_is_in_order_once_the_groups_before_it_are_taken() -> None:
    left, right = ([(row, column) for row in range(6)] for column in (0, 5))
    assert in_order(*left, (0, 1)) == 1
    assert in_order(*left[:5], (0, 1), left[5]) == 6 / 7
    # The sequences do not wait for each other.
    assert in_order(*right, (0, 4), left[0]) == 1
    assert in_order((0, 4)) == 0


def test_no_order_is_measured_where_nothing_was_taken() -> None:
    assert in_order() is None


def test_the_share_of_the_time_in_an_area_is_measured() -> None:
    # The paddle's centre is 6 px above the byte.
    upper = InRegion(thing="player", area=Rectangle(0, 34, 160, 114))
    assert value(upper, pong([60, 119, 120, 200]), "pong") == 0.5


def test_nearness_counts_only_while_both_are_there() -> None:
    level = Near(thing="player", other="ball", distance_px=8, axes=Axes.Y)
    # At byte 0 the ball is absent; centres are at byte - 6 and byte - 12.5.
    game = pong([100, 100, 100, 100], [0, 106, 114, 115])
    assert value(level, game, "pong") == pytest.approx(2 / 3)
    assert value(level, pong([100, 100]), "pong") is None


def test_nearness_along_both_axes_is_the_distance_of_centres() -> None:
    memory = np.zeros((1, 128), np.uint8)
    memory[0, [32, 34, 33, 35]] = 40, 20, 45, 25  # 3 px and 4 px apart
    game = played(memory=memory)
    near = {"thing": "player", "other": "opponent"}
    assert value(Near(**near, distance_px=5), game, "boxing") == 1  # type: ignore[arg-type]
    assert value(Near(**near, distance_px=4.9), game, "boxing") == 0  # type: ignore[arg-type]


def test_the_rate_of_a_button_counts_each_time_it_is_pressed_anew() -> None:
    actions = SPACE_INVADERS.controls.actions
    fire, left, both = (actions.index(name) for name in ("FIRE", "LEFT", "LEFTFIRE"))
    second = bytes([fire] * 10 + [both] * 10 + [left] * 20 + [both] * 20)
    game = played(actions=second)
    assert value(ActionRate(button="fire"), game) == 2
    assert value(ActionRate(button="fire", per=Per.TIME), game) == pytest.approx(2 / 3)
    assert value(ActionRate(action="LEFTFIRE"), game) == 2
    assert value(ActionRate(action="LEFT", per=Per.TIME), game) == pytest.approx(1 / 3)
    assert value(ActionRate(button="fire"), played()) is None


@pytest.mark.parametrize(("end", "alive"), [("hit", 0), ("landed", 0), ("steps", 1), (None, 1)])
def test_alive_is_who_was_not_hit_and_has_not_lost(end: str | None, alive: int) -> None:
    assert value(AliveAtEnd(), played(end=end)) == alive
    assert AliveAtEnd().is_met(alive) is bool(alive)


def test_divers_are_counted_from_memory() -> None:
    memory = np.zeros((4, 128), np.uint8)
    memory[:, 62] = [0, 1, 0, 2]
    assert value(Counted(counter="divers"), played(memory=memory), "seaquest") == 3


def test_what_is_not_stored_is_not_known() -> None:
    length, score = Length(at_least=3), GameScore()
    known, unknown = measured_before([length, score], {length.key: 4.0})
    assert (known.value, known.is_known, known.met) == (4, True, True)
    assert (unknown.value, unknown.is_known, unknown.met) == (None, False, None)
    assert known.unit is Unit.SECONDS


@pytest.mark.parametrize(
    ("given_json", "message"),
    [
        ("left", "an object with its kind"),
        ({"kind": "speed"}, "one of the kinds items, order"),
        ({}, "one of the kinds"),
        ({"kind": "score", "colour": 3}, "has at_least, at_most, but no 'colour'"),
        ({"kind": "region", "thing": "ball"}, "needs area, thing"),
        ({"kind": "region", "thing": "ball", "area": [1, 2, 3]}, "left, top, right, bottom"),
        ({"kind": "region", "thing": "ball", "area": [9, 0, 3, 5]}, "left < right"),
        ({"kind": "region", "thing": "", "area": [0, 0, 3, 5]}, "Expected a name"),
        ({"kind": "score", "at_least": "many"}, "Expected numbers"),
        ({"kind": "score", "at_least": True}, "Expected numbers"),
        ({"kind": "score", "at_least": float("nan")}, "Expected numbers"),
        ({"kind": "score", "at_least": 9, "at_most": 3}, "at_least to be at most at_most"),
        ({"kind": "rate", "button": "fire", "per": "time", "at_least": 90}, "from 0 to 1"),
        ({"kind": "rate"}, "name one"),
        ({"kind": "rate", "button": "fire", "action": "FIRE"}, "name one"),
        ({"kind": "rate", "button": "fire", "per": "hour"}, "'second', 'time'"),
        ({"kind": "alive", "at_least": 1}, "no bounds"),
        ({"kind": "items", "cells": []}, "1 to 1024"),
        ({"kind": "items", "cells": [[0]]}, "as \\[row, column\\]"),
        ({"kind": "items", "cells": [[0, -1]]}, "whole numbers"),
        ({"kind": "items", "cells": [[0, 1], [0, 1]]}, "twice"),
        ({"kind": "order", "sequences": 3}, "sequences of groups"),
        ({"kind": "order", "sequences": [[[[0, 0]], [[0, 0]]]]}, "twice"),
        ({"kind": "order", "sequences": []}, "1 to 1024"),
        ({"kind": "order", "sequences": [[[[0, n]]] for n in range(9)]}, "at most 8 sequences"),
        ({"kind": "order", "sequences": [[[[0, n]] for n in range(25)]]}, "at most 24 groups"),
        ({"kind": "nearness", "thing": "a", "other": "a", "distance_px": 3}, "different things"),
        ({"kind": "nearness", "thing": "a", "other": "b", "distance_px": -1}, "0 to 1000"),
        ({"kind": "nearness", "thing": "a", "other": "b"}, "needs"),
    ],
)
def test_what_is_not_a_measure_is_refused(given_json: object, message: str) -> None:
    with pytest.raises(Invalid, match=message):
        measure_from_json(given_json)


@pytest.mark.parametrize(
    ("one", "message"),
    [
        (Near(thing="player", other="puck", distance_px=3), "no thing .* 'puck'; it has player"),
        (InRegion(thing="player", area=Rectangle(0, 0, 161, 5)), "160 x 210 pixels"),
        (ItemsTaken(), "nothing that can be counted"),
        (ActionRate(button="jump"), "no button 'jump'; it has"),
        (ActionRate(action="JUMP"), "no action 'JUMP'; it has"),
        (Counted(counter="shots"), "no counter 'shots'; it has none"),
    ],
)
def test_what_a_game_lacks_cannot_be_measured(one: Measure, message: str) -> None:
    with pytest.raises(Invalid, match=message):
        check_measures(PONG, [one])


def test_an_item_that_a_game_lacks_cannot_be_measured() -> None:
    with pytest.raises(Invalid, match="no alien in row 7, column 1"):
        check_measures(SPACE_INVADERS, [ItemsTaken(cells=((6, 0),))])


def test_a_behaviour_measures_each_quantity_once_and_not_too_many() -> None:
    with pytest.raises(Invalid, match="measured twice"):
        measures_from_json([{"kind": "score", "at_least": 3}, {"kind": "score"}])
    many = tuple(Counted(counter=str(n)) for n in range(13))
    with pytest.raises(Invalid, match="at most 12"):
        Behaviour("a", "A", "", "pong", measures=many)
    with pytest.raises(Invalid, match="list of measures"):
        measures_from_json({"kind": "score"})
