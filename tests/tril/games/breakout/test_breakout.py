"""Bricks as memory has them are those of the picture, and are counted when they break."""

from __future__ import annotations

import numpy as np
import pytest

from tril.games import game_named
from tril.games.base import Console
from tril.games.breakout import BREAKOUT
from tril.games.breakout.wall import BRICK_PX, BRICKS, COLUMNS, LEFT_PX, ROWS, TOP_PX, standing
from tril.games.settings import GameSettings
from tril.play.episode import Episode
from tril.recording import Recorder, verify

PADDLE_X, BALL_X, BALL_Y = 72, 99, 101
BELOW_THE_WALL = 120


def _seen(console: Console) -> frozenset[tuple[int, int]]:
    """Return the bricks of the picture."""
    screen = console.screen()
    height, width = BRICK_PX
    found = set()
    for row, column in BRICKS:
        top = TOP_PX + (ROWS - 1 - row) * height
        left = LEFT_PX + column * width
        if np.median(screen[top : top + height, left : left + width]) > 0:
            found.add((row, column))
    return frozenset(found)


def _action(console: Console, frame: int) -> int:
    """Serve, and follow the ball with the paddle, a little beside its middle."""
    ram = console.ram_bytes()
    if ram[BALL_Y] == 0:
        return 1 if frame % 4 < 2 else 0
    aside = ram[BALL_X] - ram[PADDLE_X] - 8 - (frame // 97 % 3 - 1) * 4
    return 2 if aside > 3 else 3 if aside < -3 else 0


@pytest.fixture(scope="module")
def played() -> Recorder:
    """A game of 50 s, at whose frames the memory was compared with the picture."""
    game = BREAKOUT.with_settings(GameSettings(max_steps=750))
    recorder = Recorder(Episode(game.make_console(), game.starts.training[0], "over"))
    episode = recorder.episode
    while episode.end is None:
        recorder.advance(_action(episode.console, episode.frame))
        ram = episode.console.ram_bytes()
        if episode.frame % 30 == 0 and ram[BALL_Y] > BELOW_THE_WALL:
            assert standing(ram) == _seen(episode.console), episode.frame
    return recorder


def test_it_is_the_game_of_that_name_with_a_wall_of_bricks() -> None:
    assert game_named("breakout") is BREAKOUT
    console = BREAKOUT.make_console()
    console.start(BREAKOUT.starts.training[0])
    console.act(0)
    assert len(BRICKS) == ROWS * COLUMNS == 108
    assert standing(console.ram_bytes()) == _seen(console) == frozenset(BRICKS)


def test_bricks_are_taken_once_and_pay_what_the_game_pays(played: Recorder) -> None:
    cells = [one.cell for one in played.episode.taken]
    assert len(cells) > 10
    assert len(set(cells)) == len(cells)
    points = (1, 1, 4, 4, 7, 7)
    assert sum(points[row] for row, _ in cells) == played.episode.score


def test_a_replay_takes_the_same_bricks(played: Recorder) -> None:
    cells = [one.cell for one in played.episode.taken]
    verified = verify(played.recording(), cells, BREAKOUT.make_console())
    assert verified.replay.taken == played.episode.taken
