"""Behaviours that come with games: what they measure tells those who do it from those who don't."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from tril.errors import NotFound
from tril.games import game_named, game_of, published, ready_made
from tril.games.atari.ready_made import READY_MADE
from tril.games.base import Game, Taken
from tril.games.behaviours import Behaviour
from tril.games.breakout.wall import COLUMNS, ROWS
from tril.games.measuring import Measured, Played, check_measures, measure
from tril.play.episode import Episode
from tril.recording import Recording, verify
from tril.sample import sample
from tril.store.behaviours import MAX_NAME_LENGTH

GAMES = ("breakout", "space_invaders", *READY_MADE)
OFFERED = [
    behaviour
    for name in GAMES
    for behaviour in game_named(name).behaviours
    if behaviour not in published()
]


def test_there_are_ten_in_five_games_beside_those_of_space_invaders() -> None:
    others = [behaviour for behaviour in OFFERED if behaviour.game != "space_invaders"]
    assert len(others) >= 10
    assert len({behaviour.game for behaviour in others}) >= 5
    crowdplay = {behaviour.slug for behaviour in OFFERED} - {one.slug for one in others}
    assert {"outside-in", "inside-out", "keep-left", "keep-right"} <= crowdplay


@pytest.mark.parametrize("behaviour", OFFERED, ids=lambda one: f"{one.game}-{one.slug}")
def test_a_behaviour_is_complete_and_can_be_measured(behaviour: Behaviour) -> None:
    game = game_of(behaviour)
    assert behaviour.measures
    assert behaviour.description.endswith(".")
    assert len(behaviour.name) <= MAX_NAME_LENGTH
    check_measures(game, behaviour.measures)
    assert ready_made(game_named(behaviour.game), behaviour.slug) == behaviour
    outcome = verify(sample(game), measures=behaviour.measures).replay
    assert set(outcome.measured) == {one.key for one in behaviour.measures}


def test_a_behaviour_that_a_game_does_not_have_is_refused_with_those_it_has() -> None:
    with pytest.raises(NotFound, match="stay-up, level-with-the-ball"):
        ready_made(game_named("pong"), "left-tunnel")


def held(game: Game, button: str) -> int:
    return game.controls.action_for(1 << game.controls.buttons.index(button))


def played_by(
    slug: str, name: str, choose: Callable[[dict[str, tuple[float, float]]], str]
) -> bool:
    """Play a game by a rule from places of things to a button; return whether all is met."""
    game = game_named(name)
    behaviour = ready_made(game, slug)
    game = game_of(behaviour)
    console = game.make_console()
    episode = Episode(console, game.starts.training[0])
    while episode.end is None:
        memory = np.frombuffer(console.ram_bytes(), np.uint8)[None]
        places = {key: tuple(thing.places(memory)[0]) for key, thing in game.things.items()}
        button = choose(places)
        episode.advance(held(game, button) if button else game.controls.noop)
    recording = Recording(game, episode.start, episode.actions, end_rule=episode.end_rule)
    measured = verify(recording, measures=behaviour.measures).replay.measured
    met = [one.is_met(measured[one.key]) for one in behaviour.measures]
    assert None not in met
    return all(met)


def towards(height: float) -> Callable[[dict[str, tuple[float, float]]], str]:
    return lambda places: "up" if places["player"][1] > height else "down"


def level(places: dict[str, tuple[float, float]]) -> str:
    ball = places["ball"][1]
    return "" if np.isnan(ball) else towards(ball)(places)


def test_the_paddle_that_stays_up_is_told_from_the_one_below() -> None:
    assert played_by("stay-up", "pong", towards(60))
    assert not played_by("stay-up", "pong", towards(160))


def test_the_paddle_that_follows_the_ball_is_told_from_the_one_that_stays() -> None:
    assert played_by("level-with-the-ball", "pong", level)
    assert not played_by("level-with-the-ball", "pong", towards(40))


def test_the_chicken_that_waits_in_the_middle_is_told_from_the_one_that_crosses() -> None:
    def wait(places: dict[str, tuple[float, float]]) -> str:
        return "up" if places["chicken"][1] > 97 else ""

    assert played_by("wait-in-the-middle", "freeway", wait)
    assert not played_by("wait-in-the-middle", "freeway", lambda _: "up")


def test_the_submarine_near_the_surface_is_told_from_the_one_that_dives() -> None:
    assert not played_by("near-the-surface", "seaquest", lambda _: "down")
    assert played_by("near-the-surface", "seaquest", lambda _: "up")


def test_boxers_who_fight_are_told_from_those_who_do_not() -> None:
    def close(places: dict[str, tuple[float, float]]) -> str:
        (x, y), (ox, oy) = places["player"], places["opponent"]
        if abs(y - oy) > 6:
            return "up" if oy < y else "down"
        return "left" if ox < x else "right"

    assert played_by("stay-close", "boxing", close)
    assert not played_by("keep-away", "boxing", close)


def test_the_cannon_on_the_left_is_told_from_the_one_on_the_right() -> None:
    def on(side: str) -> bool:
        game = game_named("space_invaders")
        memory = np.zeros((2, 128), np.uint8)
        memory[:, 28] = 50 if side == "left" else 100
        taken = tuple(Taken(0, column, 1) for column in range(6))
        played = Played(memory, b"\0", taken, {}, 0, None)
        behaviour = ready_made(game, "keep-left")
        return all(one.met for one in measure(game, behaviour.measures, played))

    assert on("left")
    assert not on("right")


def shares(slug: str, game: str, cells: list[tuple[int, int]]) -> tuple[Measured, ...]:
    taken = tuple(Taken(*cell, frame=n) for n, cell in enumerate(cells, start=1))
    played = Played(np.zeros((1, 128), np.uint8), b"", taken, {}, 0, None)
    return measure(game_named(game), ready_made(game_named(game), slug).measures, played)


ROW_ORDER = [(row, column) for row in range(6) for column in range(6)]
OUTSIDE_IN = [(row, column) for column in (0, 5, 1, 4, 2, 3) for row in range(6)]


@pytest.mark.parametrize(
    ("slug", "cells"),
    [
        ("row-by-row", ROW_ORDER),
        ("outside-in", OUTSIDE_IN),
        ("inside-out", OUTSIDE_IN[::-1]),
    ],
)
def test_an_order_of_aliens_is_met_by_that_order_alone(
    slug: str, cells: list[tuple[int, int]]
) -> None:
    orders = (ROW_ORDER, OUTSIDE_IN, OUTSIDE_IN[::-1])
    for other in orders:
        (order, _) = shares(slug, "space_invaders", other)
        assert order.met is (other == cells)


def test_a_tunnel_leaves_the_rest_of_the_wall_alone() -> None:
    tunnel = [(row, 0) for row in range(ROWS)]
    wall = [(0, column) for column in range(2, COLUMNS)]
    assert all(one.met for one in shares("left-tunnel", "breakout", tunnel))
    assert not all(one.met for one in shares("left-tunnel", "breakout", tunnel + wall))
    assert not all(one.met for one in shares("left-tunnel", "breakout", tunnel[:3]))
