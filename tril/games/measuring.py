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
        value: Value in the measure's unit; None if nothing could be measured, or not yet.
        is_known: Whether the value has been measured.
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
        measures: Measures to take; `check_measures` has accepted them.
        played: A replay of the game.
    """
    return tuple(Measured(measure, _value(game, measure, played)) for measure in measures)


def measured_before(measures: Iterable[Measure], values: Values) -> tuple[Measured, ...]:
    """Return stored values of measures; those that are not stored are not known."""
    return tuple(
        Measured(measure, values.get(measure.key), measure.key in values) for measure in measures
    )


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


def mean_of(measurements: Iterable[Measured]) -> MeasureMean | None:
    """Return the mean of a measure over games; None if none has a value."""
    with_value = [measured for measured in measurements if measured.value is not None]
    if not with_value:
        return None
    met = [measured.met for measured in with_value]
    return MeasureMean(
        n=len(with_value),
        mean=float(np.mean([measured.value for measured in with_value])),
        n_met=None if None in met else sum(map(bool, met)),
    )


def reads_memory(game: Game, measure: Measure) -> bool:
    """Return whether a measure needs the memory of every frame."""
    return isinstance(measure, InRegion | Near) or (
        isinstance(measure, Counted) and measure.counter in game.tallies
    )


def check_measures(game: Game, measures: Iterable[Measure]) -> None:
    """Check that a game has what is measured.

    Raises:
        Invalid: It has no such thing, item, button or counter; says which it has.
    """
    for measure in measures:
        if isinstance(measure, InRegion | Near):
            for thing in (
                (measure.thing, measure.other) if isinstance(measure, Near) else (measure.thing,)
            ):
                _check_known(game, "thing whose place is known", thing, game.things)
        if isinstance(measure, InRegion) and (
            measure.area.right > game.screen.width or measure.area.bottom > game.screen.height
        ):
            raise Invalid(
                f"Expected an area within the screen of {game.screen.width} x"
                f" {game.screen.height} pixels, got one to {measure.area.right},"
                f" {measure.area.bottom}."
            )
        if isinstance(measure, ItemsTaken | ItemsInOrder):
            _check_cells(game, measure)
        if isinstance(measure, ActionRate) and measure.button is not None:
            _check_known(game, "button", measure.button, game.controls.buttons)
        if isinstance(measure, ActionRate) and measure.action is not None:
            _check_known(game, "action", measure.action, game.controls.actions)
        if isinstance(measure, Counted):
            _check_known(game, "counter", measure.counter, (*game.counters, *game.tallies))


def measurable(game: Game, measures: Iterable[Measure]) -> tuple[Measure, ...]:
    """Return those measures that a game can be measured by, as versions of it may differ."""
    accepted = []
    for measure in measures:
        with suppress(Invalid):
            check_measures(game, [measure])
            accepted.append(measure)
    return tuple(accepted)


def _check_known(game: Game, kind: str, name: str, known_names: Iterable[str]) -> None:
    names = tuple(known_names)
    if name not in names:
        has = f"it has {', '.join(names)}" if names else "it has none"
        raise Invalid(f"{game.title} has no {kind} {name!r}; {has}.")


def _check_cells(game: Game, measure: ItemsTaken | ItemsInOrder) -> None:
    if game.items is None:
        raise Invalid(f"{game.title} has nothing that can be counted.")
    for cell in _cells(measure):
        if cell not in game.items:
            raise Invalid(f"{game.title} has no {game.items.singular} in {cell_name(cell)}.")


def _cells(measure: ItemsTaken | ItemsInOrder) -> tuple[Cell, ...]:
    if isinstance(measure, ItemsTaken):
        return measure.cells or ()
    return tuple(cell for groups in measure.sequences for group in groups for cell in group)


def _value(game: Game, measure: Measure, played: Played) -> float | None:
    if isinstance(measure, ItemsTaken):
        return float(
            sum(measure.cells is None or item.cell in measure.cells for item in played.taken)
        )
    if isinstance(measure, ItemsInOrder):
        return _share_in_order(measure, [item.cell for item in played.taken])
    if isinstance(measure, InRegion):
        return _share_in_region(measure, game.things[measure.thing].places(played.memory))
    if isinstance(measure, Near):
        places = [
            game.things[name].places(played.memory) for name in (measure.thing, measure.other)
        ]
        return _share_near(measure, places[0] - places[1])
    if isinstance(measure, ActionRate):
        return _rate(game, measure, played.actions)
    if isinstance(measure, GameScore):
        return played.score
    if isinstance(measure, AliveAtEnd):
        lost = (EndKind.DEATH, EndKind.FAILED)
        return float(played.end is None or game.end(played.end).kind not in lost)
    if isinstance(measure, Length):
        return len(played.actions) / game.clock.frame_rate_hz
    if isinstance(measure, Counted):
        tally = game.tallies.get(measure.counter)
        return float(
            played.counters.get(measure.counter, 0) if tally is None else tally.count(played.memory)
        )
    raise TypeError(f"Expected a measure of a known kind, got {measure!r}.")


def _share_in_order(measure: ItemsInOrder, taken: list[Cell]) -> float | None:
    turns = {
        cell: (number, place)
        for number, groups in enumerate(measure.sequences)
        for place, group in enumerate(groups)
        for cell in group
    }
    pending = [[set(group) for group in groups] for groups in measure.sequences]
    in_order = []
    for cell in taken:
        if cell in turns:
            number, place = turns[cell]
            in_order.append(not any(pending[number][:place]))
            pending[number][place].discard(cell)
    return float(np.mean(in_order)) if in_order else None


def _share_in_region(measure: InRegion, places: Places) -> float | None:
    x, y = places.T
    inside = (measure.area.left <= x) & (x < measure.area.right)
    inside &= (measure.area.top <= y) & (y < measure.area.bottom)
    return _share(inside, places)


def _share_near(measure: Near, apart: Places) -> float | None:
    x, y = apart.T
    distance = {Axes.X: np.abs(x), Axes.Y: np.abs(y), Axes.BOTH: np.hypot(x, y)}[measure.axes]
    return _share(distance <= measure.distance_px, apart)


def _share(holds: npt.NDArray[np.bool_], places: Places) -> float | None:
    """Return the share of the frames in which something holds, of those that have a place."""
    is_there = ~np.isnan(places).any(axis=1)
    return float(holds[is_there].mean()) if is_there.any() else None


def _rate(game: Game, measure: ActionRate, actions: bytes) -> float | None:
    if not actions:
        return None
    controls = game.controls
    if measure.button is not None:
        bit = 1 << controls.buttons.index(measure.button)
        counts = [bool(held & bit) for held in controls.held]
    else:
        counts = [name == measure.action for name in controls.actions]
    executed = np.array(counts)[np.frombuffer(actions, np.uint8)]
    if measure.per is Per.TIME:
        return float(executed.mean())
    begun = executed & ~np.concatenate(([False], executed[:-1]))
    return float(begun.sum()) * game.clock.frame_rate_hz / len(actions)
