"""How learning reports its progress, and how it is cancelled."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Protocol


class RunCancelled(Exception):
    """The run was cancelled. Learning code lets this pass; its checkpoint stays."""


class Progress(Protocol):
    """What learning functions report to, several times a second.

    Implementations that write to a database limit how often they do. A cancelled run stops here.
    """

    def advance(self, done: int, total: int, values: Mapping[str, float] | None = None) -> None:
        """Report that ``done`` of ``total`` units of the current stage are finished.

        Args:
            done: Finished units, 0 to ``total``; the learning function chooses the unit.
            total: Units in all.
            values: Points of curves at ``done``, by the curve's name.

        Raises:
            RunCancelled: The run is to stop here.
        """


class NullProgress:
    """Ignores all reports and never cancels."""

    def advance(self, done: int, total: int, values: Mapping[str, float] | None = None) -> None:
        """Do nothing."""


class CallbackProgress:
    """Calls a function for every report, whatever was reported.

    Args:
        callback: Function to call; an error that it raises ends the work.
    """

    def __init__(self, callback: Callable[[], None]) -> None:
        self._callback = callback

    def advance(self, done: int, total: int, values: Mapping[str, float] | None = None) -> None:
        """Call the function."""
        self._callback()


class ScaledProgress:
    """Reports part of a stage as a share of the whole stage.

    Args:
        stage: The stage's progress.
        first: Share of the stage that is finished when the part begins, 0 to 1.
        last: Share that is finished when the part ends.
    """

    UNITS = 1_000_000

    def __init__(self, stage: Progress, first: float, last: float) -> None:
        self._stage = stage
        self._first = first
        self._span = last - first

    def advance(self, done: int, total: int, values: Mapping[str, float] | None = None) -> None:
        """Report the part's progress as the stage's."""
        share = self._first + self._span * (done / total if total else 1.0)
        self._stage.advance(round(share * self.UNITS), self.UNITS, values)


class OffsetProgress:
    """Reports part of a stage in the stage's own units, over which its curves are drawn.

    Args:
        stage: The stage's progress.
        first: Units of the stage that are finished when the part begins.
        total: Units of the whole stage.
        with_values: Whether points of curves are passed on.
    """

    def __init__(
        self, stage: Progress, first: int, total: int, *, with_values: bool = True
    ) -> None:
        self._stage = stage
        self._first = first
        self._total = total
        self._with_values = with_values

    def advance(self, done: int, total: int, values: Mapping[str, float] | None = None) -> None:
        """Report the part's progress as the stage's."""
        self._stage.advance(self._first + done, self._total, values if self._with_values else None)
