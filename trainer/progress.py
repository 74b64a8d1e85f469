"""How learning tells what it has done, and how it is told to stop."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Protocol


class RunCancelled(Exception):
    """The run was cancelled; learning leaves everything as it is and lets this pass."""


class Progress(Protocol):
    """What learning functions report to.

    It is called several times a second, so an implementation that writes to a database has to
    limit how often it does. It is where a cancelled run stops.
    """

    def advance(self, done: int, total: int, values: Mapping[str, float] | None = None) -> None:
        """Take note that ``done`` of ``total`` units of the present stage are finished.

        Args:
            done: Units finished, from 0 to ``total``; the unit is the learning function's.
            total: Units in all.
            values: Points of curves that belong to ``done``, by the curve's name.

        Raises:
            RunCancelled: The run is to stop here.
        """


class NullProgress:
    """A progress that nobody watches and that never stops."""

    def advance(self, done: int, total: int, values: Mapping[str, float] | None = None) -> None:
        """Do nothing."""


class Ticking:
    """A progress of a part of the work that has no share of its own in the stage's units.

    Args:
        tick: Says where the stage is; called for every unit of the part.
    """

    def __init__(self, tick: Callable[[], None]) -> None:
        self._tick = tick

    def advance(self, done: int, total: int, values: Mapping[str, float] | None = None) -> None:
        """Say where the stage is."""
        self._tick()


class Part:
    """A part of a stage that reports as if it were a whole one.

    Args:
        whole: Where the stage reports to.
        first: The share of the stage that is finished when the part begins, 0 to 1.
        last: The share that is finished when the part ends.
        units: Units in the whole stage, which points of curves are counted in.
    """

    def __init__(self, whole: Progress, first: float, last: float, units: int = 1_000_000) -> None:
        self._whole = whole
        self._units = units
        self._first = first
        self._span = last - first

    def advance(self, done: int, total: int, values: Mapping[str, float] | None = None) -> None:
        """Report the part's progress as the stage's."""
        share = self._first + self._span * (done / total if total else 1.0)
        self._whole.advance(round(share * self._units), self._units, values)


class Section:
    """Some of a stage's units, reported in those units, so that curves can be drawn over them.

    Args:
        whole: Where the stage reports to.
        first: Units of the stage that are finished when the section begins.
        total: Units of the whole stage.
    """

    def __init__(self, whole: Progress, first: int, total: int) -> None:
        self._whole = whole
        self._first = first
        self._total = total

    def advance(self, done: int, total: int, values: Mapping[str, float] | None = None) -> None:
        """Report the section's progress as the stage's."""
        self._whole.advance(self._first + done, self._total, values)
