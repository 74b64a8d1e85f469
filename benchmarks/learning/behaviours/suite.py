"""The behaviours of the benchmark, with what they are worth in terms of the game's memory.

Addresses are those of AtariARI (Anand et al. 2019) and of Tril's own modules. Learning never sees
them: they are the truth that it is compared with.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

Memory = npt.NDArray[np.uint8]
Worth = Callable[[Memory, npt.NDArray[np.int64]], npt.NDArray[np.float64]]
"""Worth of each step from the memory after each step, (n_steps, 128), and the buttons held.

The first row is the step before; its worth is left out."""

EVENT_STEPS = 10
"""Worth of an event, in steps."""


@dataclass(frozen=True)
class Task:
    """A behaviour of the benchmark.

    Attributes:
        game: Name of the game.
        name: Name of the behaviour.
        worth: Its worth step by step.
        half: "development", "report" or "fresh": nothing is chosen on the last two.
        guide: What its players see besides, who look less than a second ahead: how near a step is
            to being worth something, -1 to 0.
        counts_events: Whether its worth counts events of `EVENT_STEPS` each, instead of steps.
    """

    game: str
    name: str
    worth: Worth
    half: str
    guide: Worth | None = None
    counts_events: bool = False


def _share(test: Callable[[Memory], npt.NDArray[np.bool_]]) -> Worth:
    return lambda memory, held: test(memory).astype(float)


def _rises(byte: int) -> Worth:
    def worth(memory: Memory, held: npt.NDArray[np.int64]) -> npt.NDArray[np.float64]:
        d = np.diff(memory[:, byte].astype(int), prepend=int(memory[0, byte]))
        return ((d > 0) & (d < 128)).astype(float) * EVENT_STEPS

    return worth


def _between(byte: int, low: int, high: int) -> Worth:
    return _share(lambda m: (m[:, byte] >= low) & (m[:, byte] <= high))


def _tia_position(byte: int) -> Callable[[Memory], npt.NDArray[np.int64]]:
    """Return what reads a horizontal position as a 2600 keeps it for its TIA, in pixels.

    The low nibble counts steps of 15 pixels; the high one, in two's complement, is taken off.
    """

    def position(memory: Memory) -> npt.NDArray[np.int64]:
        value = memory[:, byte].astype(np.int64)
        fine = ((value >> 4) ^ 8) - 8
        read: npt.NDArray[np.int64] = 15 * ((value & 15) + 1) - fine
        return read

    return position


def _level(one: int, other: int, within: int, offset: int = 0) -> Worth:
    return _share(
        lambda m: np.abs(m[:, one].astype(int) - m[:, other].astype(int) - offset) <= within
    )


def _no_button(bit: int) -> Worth:
    return lambda memory, held: (held >> bit & 1 == 0).astype(np.float64)


def _bits_cleared(places: list[tuple[int, int]]) -> Worth:
    def worth(memory: Memory, held: npt.NDArray[np.int64]) -> npt.NDArray[np.float64]:
        total = np.zeros(len(memory))
        for byte, mask in places:
            on = memory[:, byte] & mask
            total += np.diff((on == 0).astype(int), prepend=int(on[0] == 0)) > 0
        return total * EVENT_STEPS

    return worth


def _patrol(byte: int, low: int, high: int) -> Worth:
    """Ways from one side to the other; on the way a step is worth a little in its direction."""

    def worth(memory: Memory, held: npt.NDArray[np.int64]) -> npt.NDArray[np.float64]:
        x = memory[:, byte].astype(int)
        out = np.zeros(len(x))
        target = 1
        for t in range(1, len(x)):
            out[t] = np.clip((x[t] - x[t - 1]) * target, -8, 8) / 8
            if (target == 1 and x[t] >= high) or (target == -1 and x[t] <= low):
                target = -target
        return out

    return worth


def _distance(
    x: tuple[int, int],
    y: tuple[int, int],
    test: Callable[[npt.NDArray[np.float64]], npt.NDArray[np.bool_]],
) -> Worth:
    def worth(memory: Memory, held: npt.NDArray[np.int64]) -> npt.NDArray[np.float64]:
        m = memory.astype(float)
        return test(np.hypot(m[:, x[0]] - m[:, x[1]], m[:, y[0]] - m[:, y[1]])).astype(float)

    return worth


def _towards(byte: int, low: int, high: int) -> Worth:
    """Return a guide to values from low to high."""

    def guide(memory: Memory, held: npt.NDArray[np.int64]) -> npt.NDArray[np.float64]:
        value = memory[:, byte].astype(float)
        nearness: npt.NDArray[np.float64] = -np.abs(value - value.clip(low, high)) / 255
        return nearness

    return guide


def _tia_place(game: str, name: str, byte: int, low: int, high: int, half: str) -> Task:
    """Return the behaviour of keeping a place from low to high pixels, as the TIA is told it."""
    position = _tia_position(byte)

    def guide(memory: Memory, held: npt.NDArray[np.int64]) -> npt.NDArray[np.float64]:
        x = position(memory).astype(float)
        nearness: npt.NDArray[np.float64] = -np.abs(x - x.clip(low, high)) / 255
        return nearness

    return Task(
        game,
        name,
        _share(lambda m: (position(m) >= low) & (position(m) <= high)),
        half,
        guide,
    )


def _apart(one: int, other: int, offset: int = 0) -> Worth:
    """Return a guide to two bytes that differ by the offset."""

    def guide(memory: Memory, held: npt.NDArray[np.int64]) -> npt.NDArray[np.float64]:
        apart = memory[:, one].astype(float) - memory[:, other] - offset
        return -np.minimum(np.abs(apart) / 255, 1)

    return guide


def _inverse(guide: Worth) -> Worth:
    return lambda memory, held: -1 - guide(memory, held)


def _near(x: tuple[int, int], y: tuple[int, int]) -> Worth:
    return lambda memory, held: (_apart(*x)(memory, held) + _apart(*y)(memory, held)) / 2


SPLITS = DEVELOPMENT, REPORT, FRESH = ("development", "report", "fresh")
"""Fresh are games that were added when everything had been chosen."""
_BREAKOUT_LEFT = [
    (register + row, mask)
    for row in range(6)
    for register, mask in ((30, 0xC0), (24, 0xC0), (24, 0x30), (24, 0x0C))
]
_BOXERS = _near((32, 33), (34, 35))


def _place(game: str, name: str, byte: int, low: int, high: int, half: str) -> Task:
    """Return the behaviour of keeping a place, as a byte tells it."""
    return Task(game, name, _between(byte, low, high), half, _towards(byte, low, high))


TASKS: tuple[Task, ...] = (
    _place("space_invaders", "stay left", 28, 0, 59, DEVELOPMENT),
    _place("space_invaders", "stay right", 28, 95, 255, DEVELOPMENT),
    _place("space_invaders", "under the middle shield", 28, 68, 84, DEVELOPMENT),
    Task("space_invaders", "never shoot", _between(85, 246, 246), DEVELOPMENT),
    Task("space_invaders", "patrol", _patrol(28, 38, 114), DEVELOPMENT),
    Task(
        "breakout", "paddle at the left", _between(72, 55, 100), DEVELOPMENT, _towards(72, 55, 100)
    ),
    Task(
        "breakout",
        "left tunnel",
        _bits_cleared(_BREAKOUT_LEFT),
        DEVELOPMENT,
        _apart(72, 99),
        counts_events=True,
    ),
    Task(
        "breakout",
        "ball up",
        _share(lambda m: (m[:, 101] > 0) & (m[:, 101] < 90)),
        DEVELOPMENT,
        _apart(72, 99),
    ),
    _place("seaquest", "near the surface", 97, 0, 30, DEVELOPMENT),
    _place("seaquest", "deep", 97, 85, 255, DEVELOPMENT),
    Task("seaquest", "collect divers", _rises(62), DEVELOPMENT, counts_events=True),
    Task(
        "boxing",
        "keep away",
        _distance((32, 33), (34, 35), lambda d: d > 60),
        DEVELOPMENT,
        _inverse(_BOXERS),
    ),
    Task(
        "boxing",
        "close to him",
        _distance((32, 33), (34, 35), lambda d: d < 28),
        DEVELOPMENT,
        _BOXERS,
    ),
    Task("boxing", "hit him", _rises(18), DEVELOPMENT, _BOXERS, counts_events=True),
    _place("pong", "stay up", 51, 0, 90, REPORT),
    Task("pong", "level with the ball", _level(51, 54, 12), REPORT, _apart(51, 54)),
    Task("pong", "miss the ball", _rises(13), REPORT, counts_events=True),
    _place("freeway", "wait in the middle", 14, 75, 105, REPORT),
    Task("freeway", "cross", _rises(103), REPORT, _towards(14, 200, 255), counts_events=True),
    _place("ms_pacman", "lower half", 16, 98, 255, REPORT),
    _place("ms_pacman", "left half", 10, 0, 80, REPORT),
    Task("ms_pacman", "eat dots", _rises(119), REPORT, counts_events=True),
    _place("riverraid", "left bank", 51, 0, 70, REPORT),
    Task("riverraid", "never shoot", _no_button(0), REPORT),
    _tia_place("demon_attack", "stay right", 16, 100, 160, REPORT),
    _tia_place("demon_attack", "stay left", 16, 0, 60, REPORT),
    _place("tennis", "at the net", 24, 0, 115, FRESH),
    _place("tennis", "stay right", 26, 100, 255, FRESH),
    _place("frostbite", "lower floes", 100, 79, 255, FRESH),
    _place("frostbite", "stay right", 102, 100, 255, FRESH),
    _place("qbert", "low on the pyramid", 67, 100, 200, FRESH),
    _place("qbert", "right half", 43, 90, 200, FRESH),
)


def task_named(game: str, name: str) -> Task:
    """Return a behaviour of a game; raises KeyError if the benchmark has no such behaviour."""
    tasks = {(task.game, task.name): task for task in TASKS}
    return tasks[game, name]
