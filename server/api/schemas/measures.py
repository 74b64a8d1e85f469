"""Measures of behaviours, and their values in games."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import Field

from server.api.schemas.base import MAX_CELLS, Cell, Schema
from tril.games import measures
from tril.games.measures import MAX_GROUPS, MAX_MEASURES, MAX_SEQUENCES, Axes, Per, Unit
from tril.games.measuring import Measured

Pixel = Annotated[int, Field(strict=True, ge=0, le=4096)]
Bound = Annotated[float, Field(allow_inf_nan=False)]
Name = Annotated[str, Field(min_length=1, max_length=64)]
Cells = Annotated[list[Cell], Field(max_length=MAX_CELLS)]


class Measure(Schema):
    """What of a game is measured, and the bounds in which a behaviour wants it.

    Which fields a kind has is told in docs/behaviour-format.md; the others are null. ``area`` is
    left, top, right, bottom in pixels, the last two outside. Shares are from 0 to 1.
    """

    kind: Literal[
        "items", "order", "region", "nearness", "rate", "score", "alive", "length", "counter"
    ]
    at_least: Bound | None = None
    at_most: Bound | None = None
    cells: Cells | None = None
    sequences: list[Annotated[list[Cells], Field(max_length=MAX_GROUPS)]] | None = Field(
        default=None, max_length=MAX_SEQUENCES
    )
    thing: Name | None = None
    other: Name | None = None
    area: tuple[Pixel, Pixel, Pixel, Pixel] | None = None
    distance_px: Bound | None = None
    axes: Axes | None = None
    button: Name | None = None
    action: Name | None = None
    per: Per | None = None
    counter: Name | None = None

    @classmethod
    def of_measure(cls, measure: measures.Measure) -> Self:
        """Show a measure."""
        return cls.model_validate(measure.to_json())

    def measure(self) -> measures.Measure:
        """Return the measure.

        Raises:
            Invalid: The kind has other fields, or a value is not valid.
        """
        return measures.measure_from_json(self.model_dump(mode="json", exclude_none=True))


Measures = Annotated[list[Measure], Field(max_length=MAX_MEASURES)]


def measures_of(sent: list[Measure]) -> tuple[measures.Measure, ...]:
    """Return measures as they were sent.

    Raises:
        Invalid: One is not valid.
    """
    return tuple(measure.measure() for measure in sent)


class MeasureMean(Schema):
    """The mean over ``n`` games, of which ``n_met`` meet the measure; null without a bound."""

    n: int
    mean: float
    n_met: int | None


class MeasureRow(Schema):
    """A measure over a training's games.

    ``imitator`` and ``clone`` are greedy games from held-out starts, ``person`` the ranked games
    that people played; null where none has a value.
    """

    measure: Measure
    unit: Unit
    imitator: MeasureMean | None
    clone: MeasureMean | None
    person: MeasureMean | None


class MeasuredValue(Schema):
    """The value of a measure in a game, in the order of the behaviour's measures.

    ``value`` is null if there was nothing to measure, or while the value is not ``known`` yet.
    ``met`` is null without a value or a bound.
    """

    value: float | None
    unit: Unit
    met: bool | None
    known: bool

    @classmethod
    def of_measured(cls, measured: Measured) -> Self:
        """Show a value."""
        return cls.of(measured, known=measured.is_known)
