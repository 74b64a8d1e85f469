"""Catch as a game of its own: what is caught are items, so that behaviours can have targets."""

from __future__ import annotations

import hashlib
import struct
from dataclasses import dataclass

import numpy as np

from tril.games.base import (
    Clock,
    Console,
    ConsoleState,
    Controls,
    End,
    EndKind,
    EndRule,
    Game,
    ItemGrid,
    JsonObject,
    Screen,
    ScreenSpec,
    Start,
    StartCache,
    Taken,
)
from tril.games.behaviours import Behaviour
from tril.games.seeds import SeedStart, SeedStarts

COLUMNS, ROWS, FRUITS = 7, 12, 10
CELL_PX = 8
FRAMES_PER_CELL = 2
FRUIT, BASKET = (230, 80, 60), (90, 160, 240)

NOOP, LEFT, RIGHT = range(3)

MISS = EndRule("miss", "when a fruit is missed")
ALL = EndRule("all", "when all fruit has fallen")


@dataclass(frozen=True)
class CatchState:
    """The whole game: four numbers, as the fruit follows from the seed.

    Attributes:
        seed: Of the columns in which the fruit falls.
        frame: Frames since the start.
        basket: Column of the basket.
        caught: Whether each fruit was caught, as bits.
    """

    seed: int
    frame: int
    basket: int
    caught: int

    def to_bytes(self) -> bytes:
        """Return the state as bytes."""
        return struct.pack("<BIIBH", 1, self.seed, self.frame, self.basket, self.caught)


class CatchConsole:
    """Runs the game, frame by frame; deterministic in start and actions."""

    lives = 0

    def __init__(self, game: Game) -> None:
        self.game = game
        self.start(SeedStart(0))

    def start(self, start: Start) -> None:
        """Begin a game."""
        assert isinstance(start, SeedStart)
        self.restore(CatchState(start.seed, 0, COLUMNS // 2, 0))

    @property
    def n_fallen(self) -> int:
        """Number of fruits that have fallen to the bottom."""
        return self._state.frame // (FRAMES_PER_CELL * (ROWS - 1))

    @property
    def n_caught(self) -> int:
        """Number of fruits that were caught."""
        return self._state.caught.bit_count()

    @property
    def score(self) -> float:
        """Fruits caught."""
        return float(self.n_caught)

    @property
    def over(self) -> bool:
        """Whether all fruit has fallen."""
        return self.n_fallen == FRUITS

    def is_caught(self, fruit: int) -> bool:
        """Return whether a fruit, from 0, was caught."""
        return bool(self._state.caught >> fruit & 1)

    def column(self, fruit: int) -> int:
        """Return the column in which a fruit, from 0, falls."""
        return int(self._columns[fruit])

    def act(self, action: int) -> None:
        """Move the basket at every second frame, when the fruit falls by a cell."""
        if self.over:
            return
        state, n_fallen = self._state, self.n_fallen
        basket, caught = state.basket, state.caught
        if state.frame % FRAMES_PER_CELL == 0:
            basket = min(max(basket + (0, -1, 1)[action], 0), COLUMNS - 1)
        self._state = CatchState(state.seed, state.frame + 1, basket, caught)
        if self.n_fallen > n_fallen and basket == self.column(n_fallen):
            caught |= 1 << n_fallen
            self._state = CatchState(state.seed, state.frame + 1, basket, caught)

    def ram_bytes(self) -> bytes:
        """Return nothing: there is no memory to show."""
        return b""

    def state_hash(self) -> str:
        """Return a digest of the screen."""
        return hashlib.blake2b(self.screen().tobytes(), digest_size=8).hexdigest()

    def screen(self, out: Screen | None = None) -> Screen:
        """Return the screen, uint8 (96, 56, 3) RGB, in out if given."""
        cells = np.zeros((ROWS, COLUMNS, 3), np.uint8)
        if not self.over:
            row = self._state.frame // FRAMES_PER_CELL % (ROWS - 1)
            cells[row, self.column(self.n_fallen)] = FRUIT
        cells[-1, self._state.basket] = BASKET
        picture = cells.repeat(CELL_PX, axis=0).repeat(CELL_PX, axis=1)
        if out is None:
            return picture
        out[:] = picture
        return out

    def save(self) -> CatchState:
        """Return the state."""
        return self._state

    def restore(self, state: ConsoleState) -> None:
        """Restore a state."""
        assert isinstance(state, CatchState)
        self._state = state
        self._columns = np.random.default_rng(state.seed).integers(COLUMNS, size=FRUITS)

    def state_from_bytes(self, data: bytes) -> CatchState:
        """Read a state."""
        if data[:1] != b"\x01":
            raise ValueError("Expected console state version 1.")
        return CatchState(*struct.unpack("<BIIBH", data)[1:])

    def close(self) -> None:
        """Nothing to free."""


class CatchReadout:
    """Follows one episode: the fruits caught, and its end."""

    def __init__(self, console: Console, end_rule: str) -> None:
        self.taken: list[Taken] = []
        self.counters = {"missed": 0}
        self._ends_at_miss = end_rule == MISS.name
        self._n_fallen = 0

    def update(self, console: Console, frame: int) -> str | None:
        """Read a frame; return the name of the end that it brought, if any."""
        assert isinstance(console, CatchConsole)
        for fruit in range(self._n_fallen, console.n_fallen):
            if console.is_caught(fruit):
                self.taken.append(Taken(row=fruit, column=console.column(fruit), frame=frame))
            else:
                self.counters["missed"] += 1
        self._n_fallen = console.n_fallen
        if self._ends_at_miss and self.counters["missed"]:
            return "missed"
        if console.over:
            return "fallen" if self.counters["missed"] else "caught"
        return None

    def marks(self, console: Console) -> bytes:
        """Return nothing: there is no overlay."""
        return b""

    def save(self) -> JsonObject:
        """Return what is not in items and counters."""
        return {"n_fallen": self._n_fallen}

    def restore(self, state: JsonObject) -> None:
        """Restore it."""
        self._n_fallen = state["n_fallen"]


def _console(game: Game, start_cache: StartCache) -> CatchConsole:
    return CatchConsole(game)


CATCH = Game(
    name="catch",
    title="Catch",
    version="1",  # raise it whenever a replay of an old recording would differ
    clock=Clock(frame_rate_hz=24, frames_per_step=2, max_steps=FRUITS * (ROWS - 1)),
    controls=Controls(
        actions=("NOOP", "LEFT", "RIGHT"),
        buttons=("left", "right"),
        held=(0b00, 0b01, 0b10),
        default_keys={"ArrowLeft": "left", "ArrowRight": "right"},
    ),
    starts=SeedStarts("Catch", n_actions=3),
    screen=ScreenSpec(ROWS * CELL_PX, COLUMNS * CELL_PX, palette=None, grayscale=None),
    ends=(
        End("missed", EndKind.FAILED, "a fruit was missed"),
        End("fallen", EndKind.FAILED, "all fruit had fallen, and not all was caught"),
        End("caught", EndKind.WON, "all fruit was caught"),
        End("steps", EndKind.TIME, "the time was over"),
    ),
    end_rules=(MISS, ALL),
    new_console=_console,
    new_readout=CatchReadout,
    has_memory=False,
    items=ItemGrid(FRUITS, COLUMNS, "fruit", "fruits", "catch"),
    counters={"missed": "fruits missed"},
    behaviours=(
        Behaviour(
            slug="catch-left",
            name="Catch at the left",
            description="Catches what falls in the three columns at the left, and nothing else.",
            game="catch",
            target=tuple((fruit, column) for fruit in range(FRUITS) for column in range(3)),
        ),
    ),
)
