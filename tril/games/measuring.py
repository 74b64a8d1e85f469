"""Values of measures, read off a played game; and whether a game can be measured so."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from tril.errors import Invalid
from tril.games.base import Cell, EndKind, Game, Taken, cell_name
from tril.games.measures import (
    ActionRate,
    AliveAtEnd,
    Axes,
    Counted,
    GameScore,
    InRegion,
    ItemsInOrder,
    ItemsTaken,
    Length,
    Measure,
    Near,
    Per,
    Unit,
)
from tril.games.things import Memory, Places

Values = Mapping[str, float | None]
"""Values by `Measure.key`; None where there was nothing to measure."""


@dataclass(frozen=True, eq=False)
class Played:
    """A game that was played, as measures see it.

    Attributes:
        memory: The memory at the start and after every frame; no bytes where it is not needed.
        actions: The action executed at every frame, one byte each.
        taken: The items taken, in order of time.
        counters: Counts, by name.
        score: Rewards of the game itself.
        end: Name of the end, None if it was broken off.
    """

    memory: Memory
    actions: bytes
    taken: tuple[Taken, ...]
    counters: Mapping[str, int]
    score: float
    end: str | None


@dataclass(frozen=True)
class Measured:
    """The value of a measure in a game.

    Attributes:
        measure: The measure.
        value: In its unit; None if there was nothing to measure, or it is not known yet.
        is_known: Whether it has been measured.
    """

    measure: Measure
    value: float | None
    is_known: bool = True

    @property
    def unit(self) -> Unit:
        """What the value is counted in."""
        return self.measure.unit

    @property
    def met(self) -> bool | None:
        """Whether the value is within the bounds; None without a value or a bound."""
        return self.measure.is_met(self.value)


def measure(game: Game, measures: Iterable[Measure], played: Played) -> tuple[Measured, ...]:
    """Measure a game that was played.

    Args:
        game: The game.
        measures: What to measure; `check_measures` has accepted them.
        played: A replay of the game.
    """
    return tuple(Measured(one, _value(game, one, played)) for one in measures)


def measured_before(measures: Iterable[Measure], values: Values) -> tuple[Measured, ...]:
    """Return stored values of measures; those that are not stored are not known."""
    return tuple(Measured(one, values.get(one.key), one.key in values) for one in measures)


@dataclass(frozen=True)
class MeasureMean:
    """A measure over several games.

    Attributes:
        n: Number of games with a value.
        mean: Mean of the values.
        n_met: Number of games that meet it; None without a bound.
    """

    n: int
    mean: float
    n_met: int | None


def mean_of(games: Iterable[Measured]) -> MeasureMean | None:
    """Return the mean of a measure over games; None if none has a value."""
    with_value = [one for one in games if one.value is not None]
    if not with_value:
        return None
    met = [one.met for one in with_value]
    return MeasureMean(
        n=len(with_value),
        mean=float(np.mean([one.value for one in with_value])),
        n_met=None if None in met else sum(map(bool, met)),
    )


def reads_memory(game: Game, one: Measure) -> bool:
    """Return whether a measure needs the memory of every frame."""
    return isinstance(one, InRegion | Near) or (
        isinstance(one, Counted) and one.counter in game.tallies
    )


def check_measures(game: Game, measures: Iterable[Measure]) -> None:
    """Check that a game has what is measured.

    Raises:
        Invalid: It has no such thing, item, button or counter; says which it has.
    """
    for one in measures:
        if isinstance(one, InRegion | Near):
            for thing in (one.thing, one.other) if isinstance(one, Near) else (one.thing,):
                _check_known(game, "thing whose place is known", thing, game.things)
        if isinstance(one, InRegion) and (
            one.area.right > game.screen.width or one.area.bottom > game.screen.height
        ):
            raise Invalid(
                f"Expected an area within the screen of {game.screen.width} x"
                f" {game.screen.height} pixels, got one to {one.area.right}, {one.area.bottom}."
            )
        if isinstance(one, ItemsTaken | ItemsInOrder):
            _check_cells(game, one)
        if isinstance(one, ActionRate) and one.button is not None:
            _check_known(game, "button", one.button, game.controls.buttons)
        if isinstance(one, ActionRate) and one.action is not None:
            _check_known(game, "action", one.action, game.controls.actions)
        if isinstance(one, Counted):
            _check_known(game, "counter", one.counter, (*game.counters, *game.tallies))


def measurable(game: Game, measures: Iterable[Measure]) -> tuple[Measure, ...]:
    """Return those measures that a game can be measured by, as versions of it may differ."""
    accepted = []
    for one in measures:
        with suppress(Invalid):
            check_measures(game, [one])
            accepted.append(one)
    return tuple(accepted)


def _check_known(game: Game, what: str, name: str, known: Iterable[str]) -> None:
    names = tuple(known)
    if name not in names:
        has = f"it has {', '.join(names)}" if names else "it has none"
        raise Invalid(f"{game.title} has no {what} {name!r}; {has}.")


def _check_cells(game: Game, one: ItemsTaken | ItemsInOrder) -> None:
    if game.items is None:
        raise Invalid(f"{game.title} has nothing that can be counted.")
    for cell in _cells(one):
        if cell not in game.items:
            raise Invalid(f"{game.title} has no {game.items.singular} in {cell_name(cell)}.")


def _cells(one: ItemsTaken | ItemsInOrder) -> tuple[Cell, ...]:
    if isinstance(one, ItemsTaken):
        return one.cells or ()
    return tuple(cell for groups in one.sequences for group in groups for cell in group)


def _value(game: Game, one: Measure, played: Played) -> float | None:
    if isinstance(one, ItemsTaken):
        return float(sum(one.cells is None or item.cell in one.cells for item in played.taken))
    if isinstance(one, ItemsInOrder):
        return _share_in_order(one, [item.cell for item in played.taken])
    if isinstance(one, InRegion):
        return _share_in_region(one, game.things[one.thing].places(played.memory))
    if isinstance(one, Near):
        places = [game.things[name].places(played.memory) for name in (one.thing, one.other)]
        return _share_near(one, places[0] - places[1])
    if isinstance(one, ActionRate):
        return _rate(game, one, played.actions)
    if isinstance(one, GameScore):
        return played.score
    if isinstance(one, AliveAtEnd):
        lost = (EndKind.DEATH, EndKind.FAILED)
        return float(played.end is None or game.end(played.end).kind not in lost)
    if isinstance(one, Length):
        return len(played.actions) / game.clock.frame_rate_hz
    if isinstance(one, Counted):
        tally = game.tallies.get(one.counter)
        return float(
            played.counters.get(one.counter, 0) if tally is None else tally.count(played.memory)
        )
    raise TypeError(f"Expected a measure of a known kind, got {one!r}.")


def _share_in_order(one: ItemsInOrder, taken: list[Cell]) -> float | None:
    turns = {
        cell: (number, place)
        for number, groups in enumerate(one.sequences)
        for place, group in enumerate(groups)
        for cell in group
    }
    left = [[set(group) for group in groups] for groups in one.sequences]
    in_order = []
    for cell in taken:
        if cell in turns:
            number, place = turns[cell]
            in_order.append(not any(left[number][:place]))
            left[number][place].discard(cell)
    return float(np.mean(in_order)) if in_order else None


def _share_in_region(one: InRegion, places: Places) -> float | None:
    x, y = places.T
    inside = (one.area.left <= x) & (x < one.area.right)
    inside &= (one.area.top <= y) & (y < one.area.bottom)
    return _share(inside, places)


def _share_near(one: Near, apart: Places) -> float | None:
    x, y = apart.T
    distance = {Axes.X: np.abs(x), Axes.Y: np.abs(y), Axes.BOTH: np.hypot(x, y)}[one.axes]
    return _share(distance <= one.distance_px, apart)


def _share(holds: npt.NDArray[np.bool_], places: Places) -> float | None:
    """Return the share of the frames in which something holds, of those that have a place."""
    is_there = ~np.isnan(places).any(axis=1)
    return float(holds[is_there].mean()) if is_there.any() else None


def _rate(game: Game, one: ActionRate, actions: bytes) -> float | None:
    if not actions:
        return None
    controls = game.controls
    if one.button is not None:
        bit = 1 << controls.buttons.index(one.button)
        counts = [bool(held & bit) for held in controls.held]
    else:
        counts = [name == one.action for name in controls.actions]
    executed = np.array(counts)[np.frombuffer(actions, np.uint8)]
    if one.per is Per.TIME:
        return float(executed.mean())
    begun = executed & ~np.concatenate(([False], executed[:-1]))
    return float(begun.sum()) * game.clock.frame_rate_hz / len(actions)
