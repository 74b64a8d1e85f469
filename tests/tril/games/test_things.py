"""Things whose place is read from memory are where the picture shows them."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest

from tril.errors import Invalid
from tril.games import game_named
from tril.games.atari import family
from tril.games.atari.catalogue import entries
from tril.games.things import Absence, Axis, Memory, Tally, Thing, thing_from_json
from tril.play.episode import Episode

SECONDS = 30
LONGEST_HOLD = 24
SEEN_SHARE = 0.9
MARGIN_PX = 2


@dataclass(frozen=True)
class Look:
    """How a thing looks: its value in the palette, its width and height in pixels."""

    colour: int
    width: int
    height: int


LOOKS = {
    ("boxing", "opponent"): Look(0, 14, 46),
    ("boxing", "player"): Look(12, 14, 46),
    ("breakout", "ball"): Look(70, 2, 4),
    ("breakout", "paddle"): Look(70, 16, 4),
    ("freeway", "chicken"): Look(30, 7, 8),
    ("ms_pacman", "blinky"): Look(70, 8, 10),
    ("ms_pacman", "inky"): Look(184, 8, 10),
    ("ms_pacman", "pinky"): Look(88, 8, 10),
    ("ms_pacman", "player"): Look(42, 8, 10),
    ("ms_pacman", "sue"): Look(38, 8, 10),
    ("pong", "ball"): Look(14, 2, 4),
    ("pong", "opponent"): Look(56, 4, 16),
    ("pong", "player"): Look(200, 4, 16),
    ("riverraid", "plane"): Look(28, 7, 14),
    ("seaquest", "submarine"): Look(24, 16, 8),
    ("skiing", "skier"): Look(72, 7, 20),
    ("space_invaders", "cannon"): Look(196, 7, 10),
    ("space_invaders", "missile"): Look(6, 1, 8),
}

DIVER = Look(130, 8, 9)
DIVER_PX = 17

Screens = npt.NDArray[np.uint8]


@pytest.fixture(scope="module")
def plays() -> dict[str, tuple[Memory, Screens]]:
    """Return random play of each game with things: its memory and its screens in every frame."""
    return {name: _play(name) for name in sorted({game for game, _ in LOOKS})}


def _play(name: str) -> tuple[Memory, Screens]:
    game = game_named(name)
    rng = np.random.default_rng(0)
    console = game.make_console()
    memory: list[npt.NDArray[np.uint8]] = []
    screens: list[npt.NDArray[np.uint8]] = []
    for start in game.starts.training:
        episode = Episode(console, start, game.end_rules[-1].name, SECONDS * 60)
        while episode.end is None and len(memory) < SECONDS * 60:
            action = int(rng.integers(game.controls.n_actions))
            for _ in range(int(rng.integers(1, LONGEST_HOLD))):
                if episode.end is None:
                    episode.advance(action)
                    memory.append(np.frombuffer(console.ram_bytes(), np.uint8))
                    screens.append(console.screen())
        if len(memory) >= SECONDS * 60:
            break
    return np.array(memory), np.array(screens)


def _seen(screens: Screens, places: npt.NDArray[np.float64], look: Look) -> float:
    """Return the share of steps in which a thing is there that show its colour at its place."""
    seen, steps = 0, 0
    for first in range(0, len(screens) - 4, 4):
        there = [f for f in range(first, first + 4) if not np.isnan(places[f]).any()]
        steps += bool(there)
        seen += any(_shows(screens[frame], places[frame], look) for frame in there)
    return seen / steps


def _shows(screen: npt.NDArray[np.uint8], place: npt.NDArray[np.float64], look: Look) -> bool:
    (x, y), width, height = place, look.width / 2 + MARGIN_PX, look.height / 2 + MARGIN_PX
    top, left = max(0, int(y - height)), max(0, int(x - width))
    area = screen[top : int(y + height) + 1, left : int(x + width) + 1]
    shown = np.argwhere(area == look.colour)
    if not len(shown):
        return False
    # The middle of what is shown, as other things of the colour may reach into the area.
    middle = (shown.min(0) + shown.max(0)) / 2 + (top, left)
    return bool(abs(middle[1] - x) <= width / 2 + 1 and abs(middle[0] - y) <= height / 2 + 1)


def test_every_thing_is_looked_for() -> None:
    games = [*entries(), "space_invaders", "breakout"]
    known = {(name, thing) for name in games for thing in game_named(name).things}
    assert known == set(LOOKS)


@pytest.mark.parametrize(("game", "thing"), LOOKS)
def test_a_thing_is_seen_where_the_memory_says(
    plays: dict[str, tuple[Memory, Screens]], game: str, thing: str
) -> None:
    memory, screens = plays[game]
    look = LOOKS[game, thing]
    places = game_named(game).things[thing].places(memory)
    there = ~np.isnan(places).any(1)
    assert there.sum() > 60
    assert _seen(screens, places, look) >= SEEN_SHARE
    # Places of another time are wrong, or the test would prove nothing.
    assert _seen(screens, np.roll(places, len(places) // 3, axis=0), look) < SEEN_SHARE


def test_divers_are_counted_when_they_are_picked_up(
    plays: dict[str, tuple[Memory, Screens]],
) -> None:
    memory, screens = plays["seaquest"]
    (tally,) = game_named("seaquest").tallies.values()
    on_board = memory[1:, tally.byte]
    shown = (screens[1:, 178:187] == DIVER.colour).sum((1, 2)) / DIVER_PX
    assert set(on_board) >= {0, 1, 2}
    assert (shown == on_board).mean() > 0.99
    assert tally.count(memory) == np.maximum(np.diff(shown), 0).sum()


MEMORY = np.array([[0, 9], [3, 10], [1, 11], [4, 30]], np.uint8)


def test_a_place_is_read_from_bytes_and_none_while_absent() -> None:
    thing = Thing("ball", Axis(-2, 2, byte=1), Axis(50.5), (Absence(0, 1, 2),))
    places = thing.places(MEMORY)
    assert places[[0, 1, 3]].tolist() == [[16, 50.5], [18, 50.5], [58, 50.5]]
    assert np.isnan(places[2]).all()


def test_a_tally_counts_what_is_added_and_not_what_is_taken_off() -> None:
    assert Tally("divers", 0).count(MEMORY) == 6


def test_a_thing_that_lacks_an_axis_is_refused() -> None:
    with pytest.raises(Invalid, match="title, x and y"):
        thing_from_json({"title": "ball", "x": 3})


def test_no_thing_is_described_of_a_game_that_does_not_exist() -> None:
    known = json.loads(Path(family.__file__).with_name("things.json").read_text())
    assert set(known) <= set(entries())
