"""How a game begins, and which starts are reserved for evaluation."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tril.errors import Invalid
from tril.games.space_invaders import memory as game

EVALUATION_START_COUNT = 32


class UnknownStart(Invalid):
    """A start or start number that does not exist or is not supported."""


@dataclass(frozen=True, order=True)
class Start:
    """How a game begins, after the 128 frames of the intro.

    Attributes:
        idle_frames: frames after the intro in which no key is held, 0 to 127.
        mode: the cartridge's game mode.
        difficulty: the position of the console's difficulty switch, 0 or 1.
    """

    idle_frames: int
    mode: int = 0
    difficulty: int = 0

    def __post_init__(self) -> None:
        """Check the values.

        Raises:
            UnknownStart: a value is out of its range.
        """
        if not 0 <= self.idle_frames <= game.MAX_IDLE_FRAMES:
            raise UnknownStart(
                f"Expected 0 to {game.MAX_IDLE_FRAMES} idle frames, got {self.idle_frames}."
            )
        if self.mode not in game.MODES:
            raise UnknownStart(
                f"Expected game mode 0, got {self.mode}: the detection of aliens is only tested in"
                " mode 0."
            )
        if self.difficulty not in game.DIFFICULTIES:
            raise UnknownStart(f"Expected difficulty 0 or 1, got {self.difficulty}.")


def _permutation() -> tuple[int, ...]:
    """Return the idle frames 0..127 in a fixed order.

    49 is coprime to 128, so the sequence visits all values, with distant neighbours and evenly
    spread over the four phases of the frame skip.
    """
    count = game.MAX_IDLE_FRAMES + 1
    return tuple((11 + 49 * n) % count for n in range(count))


EVALUATION_IDLE_FRAMES: tuple[int, ...] = _permutation()[:EVALUATION_START_COUNT]
"""Idle frames of the evaluation starts, by start number."""

EVALUATION_STARTS: tuple[Start, ...] = tuple(Start(idle) for idle in EVALUATION_IDLE_FRAMES)

TRAINING_IDLE_FRAMES: tuple[int, ...] = tuple(sorted(_permutation()[EVALUATION_START_COUNT:]))
"""The idle frames for play, demonstrations and training; none is of an evaluation start."""


def spread_starts(count: int, idle_frames: Sequence[int] = TRAINING_IDLE_FRAMES) -> list[Start]:
    """Return starts spread evenly over these idle frames, at most all of them."""
    places = np.linspace(0, len(idle_frames) - 1, min(count, len(idle_frames)))
    return [Start(idle_frames[round(place)]) for place in places]


def evaluation_start(number: int) -> Start:
    """Return the evaluation start with this start number.

    Raises:
        UnknownStart: the number is out of range.
    """
    if not 0 <= number < EVALUATION_START_COUNT:
        raise UnknownStart(
            f"Expected a start number from 0 to {EVALUATION_START_COUNT - 1}, got {number}."
        )
    return EVALUATION_STARTS[number]


def evaluation_number(start: Start) -> int | None:
    """Return the start number of an evaluation start at any difficulty, None for others."""
    if start.idle_frames not in EVALUATION_IDLE_FRAMES:
        return None
    return EVALUATION_IDLE_FRAMES.index(start.idle_frames)


def draw_start(rng: np.random.Generator) -> Start:
    """Draw a start for play, demonstrations or training, never an evaluation start."""
    return Start(TRAINING_IDLE_FRAMES[rng.integers(len(TRAINING_IDLE_FRAMES))])
