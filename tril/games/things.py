"""Things of a game that have a place on the screen, read from its memory.

They serve measures and pictures, not learning.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from tril.errors import Invalid

Memory = npt.NDArray[np.uint8]
"""The memory at the start and after every frame, uint8 (frames + 1, bytes), 0 to 255."""

Places = npt.NDArray[np.float64]
"""Centre of a thing per frame, float64 (frames + 1, 2): x, y in pixels, NaN while absent."""


@dataclass(frozen=True)
class Axis:
    """One coordinate of a thing's centre: offset + scale * byte, in pixels of the screen.

    Attributes:
        offset: The coordinate where the byte is 0, or everywhere if there is no byte.
        scale: Pixels per unit of the byte.
        byte: Address of the byte; None for an axis that is fixed.
    """

    offset: float
    scale: float = 1.0
    byte: int | None = None

    def read(self, memory: Memory) -> npt.NDArray[np.float64]:
        """Return the coordinate in every frame, float64 (frames + 1,), in pixels."""
        if self.byte is None:
            return np.full(len(memory), self.offset)
        return self.offset + self.scale * memory[:, self.byte].astype(float)


@dataclass(frozen=True)
class Absence:
    """A thing is not there while a byte is in a range.

    Attributes:
        byte: Address of the byte.
        low: Lowest value of the range.
        high: Highest value of the range.
    """

    byte: int
    low: int
    high: int


@dataclass(frozen=True)
class Thing:
    """A thing with a place.

    Attributes:
        title: Name for people, e.g. "ball".
        x: Distance of its centre from the left edge of the screen.
        y: Distance of its centre from the top edge of the screen.
        absent: When it is not there; any of these is enough.
    """

    title: str
    x: Axis
    y: Axis
    absent: tuple[Absence, ...] = ()

    def places(self, memory: Memory) -> Places:
        """Return its centre in every frame."""
        places = np.stack((self.x.read(memory), self.y.read(memory)), axis=1)
        for absence in self.absent:
            value = memory[:, absence.byte]
            places[(absence.low <= value) & (value <= absence.high)] = np.nan
        return places


@dataclass(frozen=True)
class Tally:
    """A byte of the memory that counts something; what is taken off it does not count.

    Attributes:
        title: Name for people, e.g. "divers picked up".
        byte: Address of the byte.
    """

    title: str
    byte: int

    def count(self, memory: Memory) -> int:
        """Return by how much it has risen in all."""
        rises = np.diff(memory[:, self.byte].astype(int))
        return int(rises[rises > 0].sum())


def thing_from_json(data: Mapping[str, Any]) -> Thing:
    """Read a thing: title, x, y, and ranges of bytes [address, low, high] in which it is absent.

    Raises:
        Invalid: It is something else.
    """
    try:
        return Thing(
            title=data["title"],
            x=_axis(data["x"]),
            y=_axis(data["y"]),
            absent=tuple(Absence(*absence) for absence in data.get("absent", ())),
        )
    except (KeyError, TypeError):
        raise Invalid(f"Expected a thing with title, x and y, got {data!r}.") from None


def _axis(data: Any) -> Axis:
    return Axis(**data) if isinstance(data, Mapping) else Axis(float(data))
