"""Groups of facts that belong together, and what of a byte of memory can be seen."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal, Self

import numpy as np
import numpy.typing as npt

from tril.vocabulary.kinds import Array
from tril.vocabulary.shapes import ONE_WAY, Shapes, shapes_of

NEAR_PX = (8, 16, 32)
ORDERED: tuple[Aspect, ...] = ("value", "x", "y", "dx", "dy", "gone x", "gone y")
BY_PLACE: tuple[Aspect, ...] = ("gone x", "gone y")
"""Aspects of what is cleared, bin by bin."""
IN_ORDER: tuple[Aspect, ...] = ("order x", "order y")
"""Aspects of the order in which things are cleared."""
BIN_LENGTH = 2.0
"""Bins over which the prior correlation of two weights falls to 1/e."""

Source = Literal["memory", "thing", "pieces", "formation", "button", "time"]
Axis = Literal["x", "y"]
Aspect = Literal[
    "value", "changes", "bits", "held", "x", "y", "count", "comes", "moves", "dx", "dy",
    "level x", "level y", "near", "gone", "gone x", "gone y", "order x", "order y", "played",
]  # fmt: skip

_SIZES: dict[str, int] = {
    "changes": 3,
    "bits": 8,
    "held": 2,
    "count": 2,
    "comes": 2,
    "moves": 4,
    "level x": len(NEAR_PX),
    "level y": len(NEAR_PX),
    "near": len(NEAR_PX),
    "gone": 2,
    "order x": 2,
    "order y": 2,
    "played": 1,
}


@dataclass(frozen=True)
class Twin:
    """A place on the screen that a byte of memory tells.

    Attributes:
        kind: Index of the kind.
        axis: Which coordinate of it.
        table: Place in pixels by the byte's value, 256 values; NaN for those never seen.
        direction: 1 where the place grows with the byte, -1 where it falls, 0 where it does
            neither, as a position that a console takes in two nibbles.
    """

    kind: int
    axis: Axis
    table: tuple[float, ...]
    direction: int

    def places(self, values: npt.NDArray[np.uint8]) -> Array:
        """Return the place in pixels for each value of the byte, float32 (n,)."""
        places: Array = np.array(self.table, np.float32)[values]
        return places

    def to_json(self) -> dict[str, Any]:
        """Return what `from_json` reads."""
        seen = {str(value): place for value, place in enumerate(self.table) if place == place}
        return {
            "kind": self.kind,
            "axis": self.axis,
            "table": seen,
            "direction": self.direction,
        }

    @classmethod
    def from_json(cls, data: Mapping[str, Any]) -> Self:
        """Read what `to_json` returned."""
        table = tuple(float(data["table"].get(str(value), np.nan)) for value in range(256))
        return cls(data["kind"], data["axis"], table, data["direction"])

    def __eq__(self, other: object) -> bool:
        """Compare with another twin; NaN equals NaN."""
        return isinstance(other, Twin) and self.to_json() == other.to_json()

    def __hash__(self) -> int:
        """Return a hash that equal twins share."""
        return hash((self.kind, self.axis, self.direction))


@dataclass(frozen=True)
class Sign:
    """What is seen, or which button is held, where a fact of a byte holds.

    Attributes:
        group: A group of facts about what is seen, or about a button.
        fact: Index of its fact.
        correlation: Between the two facts over the steps of varied games, -1 to 1.
    """

    group: Group
    fact: int
    correlation: float


@dataclass(frozen=True)
class Group:
    """Facts that belong together.

    Attributes:
        source: Where they come from.
        subject: The byte, the button, or the kind of things; of a relation the player's kind and
            the other one; nothing of time and of the pieces of the still picture; of a formation
            nothing, or the player's kind where it is about where the nearest item is.
        aspect: What of it: "value" of a byte in bins, its "changes" (up, down, by more than one)
            and the "bits" of a slow one; "held" of a button (held, pressed); of a kind of things
            "x" and "y" in bins, "count" (any, how many), "comes" (appears, vanishes) and "moves"
            (right, left, down, up); of two kinds "dx" and "dy" in bins, "level x", "level y" and
            "near" within 8, 16 and 32 pixels; of pieces, and of a formation, what share is "gone",
            whether it grows, what share in bins of "x" and "y", or by column and row, and what
            share is gone with all before it in its line: in "order x" along rows (from the left,
            from the right), in "order y" along columns (from the top, from the bottom); of time
            "played", which holds in every step.
        edges: Between the bins; in pixels where a byte tells a place.
        twin: Of a byte the place that it tells, if any.
        signs: Of a byte that tells no place, what goes with each of its facts; None for one that
            goes with nothing, none at all if that is true of all.
    """

    source: Source
    subject: tuple[int, ...]
    aspect: Aspect
    edges: tuple[float, ...] = ()
    twin: Twin | None = None
    signs: tuple[Sign | None, ...] = ()

    @property
    def n_facts(self) -> int:
        """Number of facts."""
        return _SIZES.get(self.aspect, len(self.edges) + 1)

    @property
    def shapes(self) -> Shapes:
        """The shapes of statements about it."""
        if self.aspect in IN_ORDER:
            return ONE_WAY
        return shapes_of(self.n_facts, self.aspect in ORDERED, self.aspect in BY_PLACE)

    @property
    def prior_root(self) -> npt.NDArray[np.float64]:
        """A root of the prior covariance of the facts' weights, float64 (n_facts, n_facts).

        Neighbouring bins are alike, so that what is learned of some places holds near them.
        """
        place = np.arange(self.n_facts)
        if self.aspect not in ORDERED:
            return np.eye(self.n_facts)
        covariance = np.exp(-np.abs(place[:, None] - place) / BIN_LENGTH)
        root: npt.NDArray[np.float64] = np.linalg.cholesky(covariance)
        return root

    def to_json(self) -> dict[str, Any]:
        """Return what `from_json` reads."""
        data: dict[str, Any] = {
            "source": self.source,
            "subject": self.subject,
            "aspect": self.aspect,
            "edges": self.edges,
        }
        if self.twin is not None:
            data["twin"] = self.twin.to_json()
        if self.signs:
            data["signs"] = [
                sign and [sign.group.to_json(), sign.fact, sign.correlation] for sign in self.signs
            ]
        return data

    @classmethod
    def from_json(cls, data: Mapping[str, Any]) -> Self:
        """Read what `to_json` returned."""
        return cls(
            data["source"],
            tuple(data["subject"]),
            data["aspect"],
            tuple(data["edges"]),
            Twin.from_json(data["twin"]) if "twin" in data else None,
            tuple(
                sign and Sign(Group.from_json(sign[0]), *sign[1:]) for sign in data.get("signs", ())
            ),
        )


def edges_of(values: npt.NDArray[np.floating], n_bins: int) -> tuple[float, ...]:
    """Return edges between bins that hold about equal shares of the values."""
    distinct = np.unique(values)
    if len(distinct) <= n_bins + 2:
        return tuple(((distinct[1:] + distinct[:-1]) / 2.0).tolist())
    inner = np.quantile(values, np.linspace(0, 1, n_bins + 1)[1:-1])
    return tuple(np.unique(inner + 1e-3).tolist())


def binned(values: npt.NDArray[np.floating], edges: Sequence[float]) -> Array:
    """Return which bin each value is in, float32 (n, n_edges + 1); none for NaN."""
    bins = np.zeros((len(values), len(edges) + 1), np.float32)
    seen = np.flatnonzero(~np.isnan(values))
    bins[seen, np.searchsorted(edges, values[seen], side="right")] = 1
    return bins
