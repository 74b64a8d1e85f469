"""How games of the Atari 2600 begin, and which starts are reserved for evaluation."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from tril.games.base import JsonObject, Opening, Start, UnknownStart

EVALUATION_START_COUNT = 32
MAX_IDLE_FRAMES = 127
"""Maximum number of a start's idle frames after the intro."""


@dataclass(frozen=True, order=True)
class AtariStart(Start):
    """How a game begins, after its intro.

    Attributes:
        idle_frames: frames after the intro in which no key is held, 0 to 127.
        mode: the cartridge's game mode.
        difficulty: the position of the console's difficulty switch.
        intro: whether the intro is skipped unseen. Without, the game begins right after the reset,
            as recordings of others do; none of the starts for play or evaluation does.
    """

    idle_frames: int
    mode: int = 0
    difficulty: int = 0
    intro: bool = True

    @property
    def key(self) -> tuple[int, ...]:
        """Idle frames, mode and difficulty, and a 0 if the intro is not skipped."""
        values = (self.idle_frames, self.mode, self.difficulty)
        return values if self.intro else (*values, 0)

    def to_json(self) -> JsonObject:
        """Return the values by name; `intro` only where it is not skipped."""
        values = {
            "idle_frames": self.idle_frames,
            "mode": self.mode,
            "difficulty": self.difficulty,
        }
        return values if self.intro else values | {"intro": 0}


def _permutation() -> tuple[int, ...]:
    """Return the idle frames 0..127 in a fixed order.

    49 is coprime to 128, so the sequence visits all values, with distant neighbours and evenly
    spread over the four phases of the frame skip.
    """
    count = MAX_IDLE_FRAMES + 1
    return tuple((11 + 49 * n) % count for n in range(count))


EVALUATION_IDLE_FRAMES: tuple[int, ...] = _permutation()[:EVALUATION_START_COUNT]
"""Idle frames of the evaluation starts, by start number."""

TRAINING_IDLE_FRAMES: tuple[int, ...] = tuple(sorted(_permutation()[EVALUATION_START_COUNT:]))
"""The idle frames for play, demonstrations and training; none is of an evaluation start."""


@dataclass(frozen=True)
class Legs:
    """Openings of a game: a walk before the game is the player's.

    Starts then differ by more than a delay.

    Attributes:
        actions: of a leg, equally likely.
        count: number of legs.
        max_steps: longest leg.
        evaluation_seed: seed of the evaluation openings.
        redrawn: seeds of single start numbers, whose openings would not be survived otherwise.
    """

    actions: tuple[int, ...]
    count: int = 3
    max_steps: int = 14
    evaluation_seed: int = 1
    redrawn: dict[int, int] = field(default_factory=dict)


@dataclass(frozen=True)
class AtariStarts:
    """The starts of one game.

    Attributes:
        title: the game's name for people, for errors.
        legs: its openings.
        modes: the modes in which it may be played; the first is the default.
        difficulties: the difficulties at which it may be played; the first is the default.
        has_intro: whether an intro precedes it.
    """

    title: str
    legs: Legs
    modes: tuple[int, ...] = (0,)
    difficulties: tuple[int, ...] = (0,)
    has_intro: bool = True
    n_evaluation: int = EVALUATION_START_COUNT

    @cached_property
    def training(self) -> Sequence[Start]:
        """The starts for play, demonstrations and training."""
        return tuple(self._start(idle) for idle in TRAINING_IDLE_FRAMES)

    @property
    def options(self) -> Mapping[str, Sequence[int]]:
        """Modes and difficulties, where there are several."""
        several = {"mode": self.modes, "difficulty": self.difficulties}
        return {name: values for name, values in several.items() if len(values) > 1}

    def with_options(self, options: Mapping[str, int]) -> AtariStarts:
        """Return the starts of another mode or difficulty.

        Raises:
            UnknownStart: There is no such option or value.
        """
        for name, value in options.items():
            values = self.options.get(name)
            if values is None:
                raise UnknownStart(f"{self.title} has no {name!r} to choose.")
            if value not in values:
                raise UnknownStart(f"Expected {name} {_alternatives(values)}, got {value}.")
        return replace(
            self,
            modes=_first(self.modes, options.get("mode")),
            difficulties=_first(self.difficulties, options.get("difficulty")),
        )

    def _start(self, idle_frames: int) -> AtariStart:
        return AtariStart(idle_frames, self.modes[0], self.difficulties[0])

    def parse(self, data: JsonObject) -> AtariStart:
        """Read what `AtariStart.to_json` returned; all but the idle frames may be missing.

        Raises:
            UnknownStart: a value is missing, unknown or out of its range.
        """
        names = {"idle_frames", "mode", "difficulty", "intro"}
        for name, value in data.items():
            if name not in names:
                raise UnknownStart(f"A start has {', '.join(sorted(names))}, but no {name!r}.")
            if not isinstance(value, int) or isinstance(value, bool):
                raise UnknownStart(f"Expected an integer for a start's {name}, got {value!r}.")
        if "idle_frames" not in data:
            raise UnknownStart("A start needs its idle_frames.")
        start = AtariStart(
            data["idle_frames"],
            data.get("mode", self.modes[0]),
            data.get("difficulty", self.difficulties[0]),
            # Without an intro both are the same start.
            bool(data.get("intro", 1)) or not self.has_intro,
        )
        if data.get("intro", 1) not in (0, 1):
            raise UnknownStart(f"Expected 0 or 1 for a start's intro, got {data['intro']}.")
        if not 0 <= start.idle_frames <= MAX_IDLE_FRAMES:
            raise UnknownStart(
                f"Expected 0 to {MAX_IDLE_FRAMES} idle frames, got {start.idle_frames}."
            )
        if start.mode not in self.modes:
            raise UnknownStart(
                f"Expected game mode {_alternatives(self.modes)}, got {start.mode}: {self.title} is"
                " not tested in others."
            )
        if start.difficulty not in self.difficulties:
            raise UnknownStart(
                f"Expected difficulty {_alternatives(self.difficulties)}, got {start.difficulty}."
            )
        return start

    def evaluation(self, number: int) -> AtariStart:
        """Return the evaluation start with this start number.

        Raises:
            UnknownStart: the number is out of range.
        """
        if not 0 <= number < self.n_evaluation:
            raise UnknownStart(
                f"Expected a start number from 0 to {self.n_evaluation - 1}, got {number}."
            )
        return self._start(EVALUATION_IDLE_FRAMES[number])

    def evaluation_number(self, start: Start) -> int | None:
        """Return the start number of an evaluation start at any mode and difficulty."""
        if not isinstance(start, AtariStart) or not start.intro:
            return None
        if start.idle_frames not in EVALUATION_IDLE_FRAMES:
            return None
        return EVALUATION_IDLE_FRAMES.index(start.idle_frames)

    def draw_opening(self, start: Start, rng: np.random.Generator) -> Opening:
        """Draw a walk, each leg of one action, held for 0 to so many steps."""
        legs = self.legs
        actions: list[int] = []
        for _ in range(legs.count):
            action = legs.actions[int(rng.integers(len(legs.actions)))]
            actions += [action] * int(rng.integers(legs.max_steps, endpoint=True))
        return Opening(start, tuple(actions))

    def evaluation_opening(self, number: int) -> Opening:
        """Return the opening of an evaluation start, fixed like the start itself.

        Raises:
            UnknownStart: the number is out of range.
        """
        seed = self.legs.redrawn.get(number, self.legs.evaluation_seed)
        return self.draw_opening(self.evaluation(number), np.random.default_rng((seed, number)))


def _first(values: tuple[int, ...], chosen: int | None) -> tuple[int, ...]:
    return tuple(sorted(values, key=lambda value: (value != chosen, values.index(value))))


def _alternatives(values: Sequence[int]) -> str:
    *names, last_name = map(str, values)
    return f"{', '.join(names)} or {last_name}" if names else last_name
