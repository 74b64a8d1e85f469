"""Starts of games that draw what they need from a seed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from tril.games.base import JsonObject, Opening, Start, UnknownStart

EVALUATION_START_COUNT = 32
TRAINING_START_COUNT = 1024
MAX_SEED = 2**31 - 1
FIRST_EVALUATION_SEED = 1_000_000
"""Seed of the first evaluation start; the others follow. Those of training begin at 0."""
LONGEST_OPENING = 4
"""Steps; more of them would end some games."""
_OPENING_SEED = 1


@dataclass(frozen=True, order=True)
class SeedStart(Start):
    """How a game begins.

    Attributes:
        seed: Seed of the game's draws, 0 to 2**31 - 1.
    """

    seed: int

    @property
    def key(self) -> tuple[int, ...]:
        """The seed."""
        return (self.seed,)

    def to_json(self) -> JsonObject:
        """Return the seed by name."""
        return {"seed": self.seed}


@dataclass(frozen=True)
class SeedStarts:
    """The starts of one game.

    Attributes:
        title: The game's name for people, for errors.
        n_actions: Number of its actions, for openings.
    """

    title: str
    n_actions: int
    n_evaluation: int = EVALUATION_START_COUNT

    @cached_property
    def training(self) -> Sequence[Start]:
        """The starts for play, demonstrations and training."""
        return tuple(SeedStart(seed) for seed in range(TRAINING_START_COUNT))

    @property
    def options(self) -> Mapping[str, Sequence[int]]:
        """Nothing to choose."""
        return {}

    def with_options(self, options: Mapping[str, int]) -> SeedStarts:
        """Return these starts.

        Raises:
            UnknownStart: An option is given; there are none.
        """
        for name in options:
            raise UnknownStart(f"{self.title} has no {name!r} to choose.")
        return self

    def parse(self, data: JsonObject) -> SeedStart:
        """Read what `SeedStart.to_json` returned.

        Raises:
            UnknownStart: The seed is missing or out of its range, or there is another value.
        """
        for name in data:
            if name != "seed":
                raise UnknownStart(f"A start of {self.title} has a seed, but no {name!r}.")
        if "seed" not in data:
            raise UnknownStart(f"A start of {self.title} needs its seed.")
        seed = data["seed"]
        if not isinstance(seed, int) or isinstance(seed, bool):
            raise UnknownStart(f"Expected an integer for a start's seed, got {seed!r}.")
        if not 0 <= seed <= MAX_SEED:
            raise UnknownStart(f"Expected a seed from 0 to {MAX_SEED}, got {seed}.")
        return SeedStart(seed)

    def evaluation(self, number: int) -> SeedStart:
        """Return the evaluation start with this start number.

        Raises:
            UnknownStart: The number is out of range.
        """
        if not 0 <= number < self.n_evaluation:
            raise UnknownStart(
                f"Expected a start number from 0 to {self.n_evaluation - 1}, got {number}."
            )
        return SeedStart(FIRST_EVALUATION_SEED + number)

    def evaluation_number(self, start: Start) -> int | None:
        """Return the start number of an evaluation start, None for others."""
        if not isinstance(start, SeedStart):
            return None
        number = start.seed - FIRST_EVALUATION_SEED
        return number if 0 <= number < self.n_evaluation else None

    def draw_opening(self, start: Start, rng: np.random.Generator) -> Opening:
        """Draw up to four steps of any actions: not every game uses its seed."""
        n_steps = int(rng.integers(LONGEST_OPENING, endpoint=True))
        return Opening(start, tuple(int(a) for a in rng.integers(self.n_actions, size=n_steps)))

    def evaluation_opening(self, number: int) -> Opening:
        """Return the opening of an evaluation start, fixed like the start itself.

        Raises:
            UnknownStart: The number is out of range.
        """
        rng = np.random.default_rng((_OPENING_SEED, number))
        return self.draw_opening(self.evaluation(number), rng)
