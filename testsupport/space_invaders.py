"""Space Invaders as tests and benchmarks play it: its keys, its starts, pictures of its console."""

from __future__ import annotations

from enum import IntFlag

import numpy as np
import numpy.typing as npt

from tril.games.atari.console import AtariConsole
from tril.games.atari.palette import palette_grayscale, palette_rgb
from tril.games.atari.starts import AtariStart
from tril.games.base import Console, Start, StartCache
from tril.games.space_invaders import SPACE_INVADERS
from tril.games.space_invaders.memory import Action


class Keys(IntFlag):
    """The held buttons; the value is that of the play protocol."""

    LEFT = 1
    RIGHT = 2
    FIRE = 4


def action_for(keys: Keys) -> Action:
    """Return the action of the held buttons."""
    return Action(SPACE_INVADERS.controls.action_for(int(keys)))


def new_console(start_cache: StartCache | None = None) -> AtariConsole:
    """Make a console."""
    console = SPACE_INVADERS.make_console(start_cache)
    assert isinstance(console, AtariConsole)
    return console


def evaluation_start(number: int) -> AtariStart:
    """Return an evaluation start."""
    start = SPACE_INVADERS.starts.evaluation(number)
    assert isinstance(start, AtariStart)
    return start


EVALUATION_STARTS = tuple(map(evaluation_start, range(SPACE_INVADERS.starts.n_evaluation)))


def idle_frames(start: Start) -> int:
    """Return a start's idle frames."""
    assert isinstance(start, AtariStart)
    return start.idle_frames


def ram(console: Console) -> npt.NDArray[np.uint8]:
    """Return the memory, uint8 (128,)."""
    return np.frombuffer(console.ram_bytes(), np.uint8)


def grayscale(console: Console) -> npt.NDArray[np.uint8]:
    """Return the screen, uint8 (210, 160) of grays."""
    return palette_grayscale()[console.screen()]


def rgb(console: Console) -> npt.NDArray[np.uint8]:
    """Return the screen, uint8 (210, 160, 3) RGB."""
    return palette_rgb()[console.screen()]
