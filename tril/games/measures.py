"""Measures: what of a played game can be told in numbers, and which numbers a behaviour asks for.

They serve checklists, tables and evaluation, never learning. Each is data; `tril.games.measuring`
reads their values off a replay.
"""

from __future__ import annotations

import hashlib
import json
import math
from abc import ABC, abstractmethod
from dataclasses import dataclass, fields
from enum import StrEnum
from typing import Any, ClassVar

from tril.errors import Invalid
from tril.games.settings import Rectangle

MAX_MEASURES = 12
"""Most measures of a behaviour."""
MAX_CELLS = 1024
"""Most items that a measure may name."""
MAX_SEQUENCES = 8
"""Most sequences of an order."""
MAX_GROUPS = 24
"""Most groups of a sequence."""
MAX_DISTANCE_PX = 1000

Cells = tuple[tuple[int, int], ...]
"""Items by row from the bottom and column from the left, both from 0."""


class Unit(StrEnum):
    """What a value is counted in."""

    ITEMS = "items"
    SHARE = "share"
    """From 0 to 1."""
    PER_SECOND = "per_second"
    POINTS = "points"
    YES = "yes"
    """1 for yes, 0 for no."""
    SECONDS = "seconds"
    COUNT = "count"


class Axes(StrEnum):
    """Along which axes a distance is taken."""

    X = "x"
    Y = "y"
    BOTH = "both"


class Per(StrEnum):
    """What a rate of an action is relative to."""

    SECOND = "second"
    """How often it begins in a second."""
    TIME = "time"
    """For which share of the time it lasts."""


@dataclass(frozen=True, kw_only=True)
class Measure(ABC):
    """A quantity of a game, and the bounds that a behaviour sets it.

    Attributes:
        at_least: Lowest value that meets it, if there is one.
        at_most: Highest value that meets it, if there is one.
    """

    at_least: float | None = None
    at_most: float | None = None

    kind: ClassVar[str]

    def __post_init__(self) -> None:
        """Check the bounds.

        Raises:
            Invalid: They contradict each other, or no value can meet them.
        """
        bounds = [bound for bound in (self.at_least, self.at_most) if bound is not None]
        if not all(_is_number(bound) for bound in bounds):
            raise Invalid(f"Expected numbers as bounds of {self.kind!r}, got {bounds}.")
        if self.unit is Unit.SHARE and not all(0 <= bound <= 1 for bound in bounds):
            raise Invalid(f"Expected a share from 0 to 1 as bound of {self.kind!r}, got {bounds}.")
        if len(bounds) == 2 and bounds[0] > bounds[1]:
            raise Invalid(
                f"Expected at_least to be at most at_most, got {bounds[0]} and {bounds[1]}."
            )

    @property
    @abstractmethod
    def unit(self) -> Unit:
        """What its values are counted in."""

    @property
    def key(self) -> str:
        """A digest of the quantity without its bounds, by which values are stored."""
        quantity = self.to_json()
        quantity.pop("at_least", None)
        quantity.pop("at_most", None)
        text = json.dumps(quantity, sort_keys=True, separators=(",", ":"))
        return hashlib.blake2b(text.encode(), digest_size=8).hexdigest()

    def is_met(self, value: float | None) -> bool | None:
        """Return whether a value is within the bounds; None without a value or a bound."""
        if value is None or (self.at_least is None and self.at_most is None):
            return None
        low = -math.inf if self.at_least is None else self.at_least
        high = math.inf if self.at_most is None else self.at_most
        return low <= value <= high

    def to_json(self) -> dict[str, Any]:
        """Return its kind and what is set; `measure_from_json` reads it."""
        data: dict[str, Any] = {"kind": self.kind}
        for name in sorted(field.name for field in fields(self)):
            value = getattr(self, name)
            if value is not None:
                data[name] = _plain(value)
        return data


@dataclass(frozen=True, kw_only=True)
class ItemsTaken(Measure):
    """Number of items taken.

    Attributes:
        cells: The items that count; None for all.
    """

    cells: Cells | None = None

    kind: ClassVar[str] = "items"
    unit = Unit.ITEMS

    def __post_init__(self) -> None:
        """Check the cells."""
        super().__post_init__()
        if self.cells is not None:
            object.__setattr__(self, "cells", _cells(self.cells))


@dataclass(frozen=True, kw_only=True)
class ItemsInOrder(Measure):
    """Share of the items taken that were taken in their turn.

    An item's turn has come when all items of the earlier groups of its sequence are taken. Items
    of no sequence do not count. Row by row is one sequence of rows; from the outside inwards are
    two, one of columns from the left and one from the right (CrowdPlay, Gerstgrasser et al. 2022).

    Attributes:
        sequences: Of each sequence, the groups of items in their order.
    """

    sequences: tuple[tuple[Cells, ...], ...]

    kind: ClassVar[str] = "order"
    unit = Unit.SHARE

    def __post_init__(self) -> None:
        """Check the cells."""
        super().__post_init__()
        try:
            sequences = tuple(tuple(map(_cells, groups)) for groups in self.sequences)
        except TypeError:
            raise Invalid("Expected sequences of groups of items [row, column].") from None
        cells = [cell for groups in sequences for group in groups for cell in group]
        if len(sequences) > MAX_SEQUENCES:
            raise Invalid(f"Expected at most {MAX_SEQUENCES} sequences, got {len(sequences)}.")
        if (longest := max(map(len, sequences), default=0)) > MAX_GROUPS:
            raise Invalid(f"Expected at most {MAX_GROUPS} groups in a sequence, got {longest}.")
        if not cells or len(cells) > MAX_CELLS:
            raise Invalid(f"Expected an order of 1 to {MAX_CELLS} items, got {len(cells)}.")
        if len(set(cells)) != len(cells):
            raise Invalid("An item is listed twice in an order.")
        object.__setattr__(self, "sequences", sequences)


@dataclass(frozen=True, kw_only=True)
class InRegion(Measure):
    """Share of the time for which a thing is in an area of the screen, while it is there.

    Attributes:
        thing: Name of the thing.
        area: The area, which its centre is in.
    """

    thing: str
    area: Rectangle

    kind: ClassVar[str] = "region"
    unit = Unit.SHARE

    def __post_init__(self) -> None:
        """Check the area."""
        super().__post_init__()
        _check_names(self.thing)
        object.__setattr__(self, "area", _rectangle(self.area))


@dataclass(frozen=True, kw_only=True)
class Near(Measure):
    """Share of the time for which two things are near each other, while both are there.

    Attributes:
        thing: Name of one.
        other: Name of the other.
        distance_px: Distance of their centres up to which they are near.
        axes: Along which axes it is taken.
    """

    thing: str
    other: str
    distance_px: float
    axes: Axes = Axes.BOTH

    kind: ClassVar[str] = "nearness"
    unit = Unit.SHARE

    def __post_init__(self) -> None:
        """Check things and distance."""
        super().__post_init__()
        _check_names(self.thing, self.other)
        if self.thing == self.other:
            raise Invalid("Expected two different things, got the same one twice.")
        if not _is_number(self.distance_px) or not 0 <= self.distance_px <= MAX_DISTANCE_PX:
            raise Invalid(
                f"Expected a distance of 0 to {MAX_DISTANCE_PX} pixels, got {self.distance_px!r}."
            )
        object.__setattr__(self, "axes", _choice(Axes, self.axes, "axes"))


@dataclass(frozen=True, kw_only=True)
class ActionRate(Measure):
    """How often or for how long a button is held, or an action executed.

    Attributes:
        button: Name of the button; None if it is an action.
        action: Name of the action; None if it is a button.
        per: What the rate is relative to.
    """

    button: str | None = None
    action: str | None = None
    per: Per = Per.SECOND

    kind: ClassVar[str] = "rate"

    def __post_init__(self) -> None:
        """Check button and action."""
        object.__setattr__(self, "per", _choice(Per, self.per, "per"))
        super().__post_init__()
        if (self.button is None) is (self.action is None):
            raise Invalid("The rate of an action is that of a button or of an action: name one.")
        _check_names(self.button or self.action)

    @property
    def unit(self) -> Unit:
        """What its values are counted in."""
        return Unit.PER_SECOND if self.per is Per.SECOND else Unit.SHARE


@dataclass(frozen=True, kw_only=True)
class GameScore(Measure):
    """Points that the game itself counts."""

    kind: ClassVar[str] = "score"
    unit = Unit.POINTS


@dataclass(frozen=True, kw_only=True)
class AliveAtEnd(Measure):
    """Whether the player is alive at the end; met if so."""

    kind: ClassVar[str] = "alive"
    unit = Unit.YES

    def __post_init__(self) -> None:
        """Check that there are no bounds."""
        super().__post_init__()
        if self.at_least is not None or self.at_most is not None:
            raise Invalid("Being alive at the end has no bounds.")

    def is_met(self, value: float | None) -> bool | None:
        """Return whether the player is alive."""
        return None if value is None else value > 0


@dataclass(frozen=True, kw_only=True)
class Length(Measure):
    """How long the game lasts."""

    kind: ClassVar[str] = "length"
    unit = Unit.SECONDS


@dataclass(frozen=True, kw_only=True)
class Counted(Measure):
    """What the game's readout or a byte of its memory counts, such as missiles fired.

    Attributes:
        counter: Name of the counter.
    """

    counter: str

    kind: ClassVar[str] = "counter"
    unit = Unit.COUNT

    def __post_init__(self) -> None:
        """Check the name."""
        super().__post_init__()
        _check_names(self.counter)


KINDS: dict[str, type[Measure]] = {
    kind.kind: kind
    for kind in (
        ItemsTaken,
        ItemsInOrder,
        InRegion,
        Near,
        ActionRate,
        GameScore,
        AliveAtEnd,
        Length,
        Counted,
    )
}


def measure_from_json(data: Any) -> Measure:
    """Read what `Measure.to_json` returned.

    Raises:
        Invalid: It is something else.
    """
    kinds = ", ".join(KINDS)
    if not isinstance(data, dict):
        raise Invalid(f"Expected a measure as an object with its kind ({kinds}), got {data!r}.")
    values = dict(data)
    kind = KINDS.get(str(values.pop("kind", None)))
    if kind is None:
        raise Invalid(f"Expected a measure of one of the kinds {kinds}, got {data.get('kind')!r}.")
    names = {field.name for field in fields(kind)}
    if unknown := sorted(set(values) - names):
        raise Invalid(
            f"A measure of the kind {kind.kind!r} has {', '.join(sorted(names))}, but no"
            f" {unknown[0]!r}."
        )
    try:
        return kind(**values)
    except TypeError:
        required = sorted(names - {"at_least", "at_most"})
        raise Invalid(
            f"A measure of the kind {kind.kind!r} needs {', '.join(required)}; got"
            f" {json.dumps(values)}."
        ) from None


def measures_from_json(data: Any) -> tuple[Measure, ...]:
    """Read a list of measures.

    Raises:
        Invalid: One is not a measure, there are too many, or one is there twice.
    """
    if not isinstance(data, list):
        raise Invalid(f"Expected a list of measures, got {data!r}.")
    measures = tuple(map(measure_from_json, data))
    check_number(measures)
    return measures


def check_number(measures: tuple[Measure, ...]) -> None:
    """Check that there are not too many measures, and each quantity once.

    Raises:
        Invalid: There are, or a quantity is measured twice.
    """
    if len(measures) > MAX_MEASURES:
        raise Invalid(f"A behaviour has at most {MAX_MEASURES} measures, got {len(measures)}.")
    if len({measure.key for measure in measures}) != len(measures):
        raise Invalid("The same is measured twice. Set both bounds in one measure.")


def _plain(value: Any) -> Any:
    if isinstance(value, Rectangle):
        return [value.left, value.top, value.right, value.bottom]
    if isinstance(value, tuple):
        return [_plain(part) for part in value]
    return value.value if isinstance(value, StrEnum) else value


def _is_number(value: object) -> bool:
    is_number = isinstance(value, int | float) and not isinstance(value, bool)
    return is_number and math.isfinite(value)  # type: ignore[arg-type]


def _is_index(value: object) -> bool:
    return isinstance(value, int) and not isinstance(value, bool) and value >= 0


def _cells(value: Any) -> Cells:
    try:
        cells = tuple((row, column) for row, column in value)
    except (TypeError, ValueError):
        raise Invalid(f"Expected items as [row, column], got {value!r}.") from None
    if not all(_is_index(row) and _is_index(column) for row, column in cells):
        raise Invalid("Expected items as [row, column] with whole numbers from 0.")
    if not 1 <= len(cells) <= MAX_CELLS:
        raise Invalid(f"Expected 1 to {MAX_CELLS} items, got {len(cells)}.")
    if len(set(cells)) != len(cells):
        raise Invalid("An item is listed twice.")
    return cells


def _rectangle(value: Any) -> Rectangle:
    if isinstance(value, Rectangle):
        return value
    if isinstance(value, list | tuple) and len(value) == 4 and all(map(_is_index, value)):
        return Rectangle(*value)
    raise Invalid(f"Expected an area as [left, top, right, bottom] in pixels, got {value!r}.")


def _check_names(*names: object) -> None:
    for name in names:
        if not isinstance(name, str) or not name:
            raise Invalid(f"Expected a name, got {name!r}.")


def _choice(kind: type[StrEnum], value: Any, name: str) -> StrEnum:
    try:
        return kind(value)
    except ValueError:
        choices = ", ".join(repr(choice.value) for choice in kind)
        raise Invalid(f"Expected {name} to be one of {choices}, got {value!r}.") from None
