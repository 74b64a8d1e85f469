"""What the tests of games and of play share: one console, one long game, random play."""

import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from tril.games.atari.console import AtariConsole
from tril.games.atari.starts import AtariStart
from tril.games.base import Console, Start, Taken
from tril.games.space_invaders import SPACE_INVADERS
from tril.play.episode import Episode

LONG_START = AtariStart(5)
LONG_GAME_FRAMES = 6000
LONG_GAME = Path(__file__).parents[1] / "data" / "long-game.json"
"""Its actions, each with the number of frames that it is held."""


@dataclass(frozen=True)
class LongGame:
    """A game in which all columns are cleared, one after the other, from the left."""

    start: Start
    actions: bytes
    hits: tuple[Taken, ...]
    end: str | None


@pytest.fixture(scope="session")
def console() -> AtariConsole:
    """A console; every test begins with a start of its own."""
    console = SPACE_INVADERS.make_console()
    assert isinstance(console, AtariConsole)
    return console


@pytest.fixture(scope="session")
def long_game(console: Console) -> LongGame:
    episode = Episode(console, LONG_START, max_frames=LONG_GAME_FRAMES)
    for action, n_frames in json.loads(LONG_GAME.read_text()):
        for _ in range(n_frames):
            episode.advance(action)
    return LongGame(LONG_START, episode.actions, episode.taken, episode.end)


def random_actions(seed: int, frames: int, hold: int = 4) -> list[int]:
    """Return random actions for so many frames, each held for some."""
    rng = np.random.default_rng(seed)
    chosen = rng.integers(6, size=-(-frames // hold))
    return [int(action) for action in np.repeat(chosen, hold)[:frames]]
