"""What the tests of games and of play share: one console, one long game, random play."""

import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from tril.games.atari.console import Console
from tril.play.episode import EndReason, Episode, Hit, Start

LONG_START = Start(5)
LONG_GAME_FRAMES = 6000
LONG_GAME = Path(__file__).parents[1] / "data" / "long-game.json"
"""Its actions, each with the number of frames that it is held."""


@dataclass(frozen=True)
class LongGame:
    """A game in which all columns are cleared, one after the other, from the left."""

    start: Start
    actions: bytes
    hits: tuple[Hit, ...]
    end: EndReason | None


@pytest.fixture(scope="session")
def console() -> Console:
    """A console; every test begins with a start of its own."""
    return Console()


@pytest.fixture(scope="session")
def long_game(console: Console) -> LongGame:
    episode = Episode(console, LONG_START, max_frames=LONG_GAME_FRAMES)
    for action, n_frames in json.loads(LONG_GAME.read_text()):
        for _ in range(n_frames):
            episode.advance(action)
    return LongGame(LONG_START, episode.actions, episode.hits, episode.end)


def random_actions(seed: int, frames: int, hold: int = 4) -> list[int]:
    """Return random actions for so many frames, each held for some."""
    rng = np.random.default_rng(seed)
    chosen = rng.integers(6, size=-(-frames // hold))
    return [int(action) for action in np.repeat(chosen, hold)[:frames]]
