"""How a game was played: what its recording says of latency and of helps to play well. Pure."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Self

from pydantic import BaseModel, ConfigDict, ValidationError

KEY = "play"
"""Under which a recording's conditions hold these."""

BAD_P95_MS = 100.0
"""A press in twenty that shows later than six frames at 60 Hz is more than a person steers by."""
BAD_DROPPED_SHARE = 0.05
"""One frame in twenty that was not drawn can be seen as stutter."""


@dataclass(frozen=True)
class Latency:
    """How late a game was seen.

    Attributes:
        presses: How many presses of a key were timed.
        p50_ms: Milliseconds from the event of a key to the drawing of the first frame shown that
            was executed with it, the median by nearest rank; None without presses.
        p95_ms: The same for 95 of 100 presses.
        frames_dropped: Frames that were executed and not drawn.
        is_bad: Whether that was too late or too many to play well by.
    """

    presses: int
    p50_ms: float | None
    p95_ms: float | None
    frames_dropped: int
    is_bad: bool


@dataclass
class PlayConditions:
    """How a game was played, by the frame, so that what is run back can be taken out again.

    Attributes:
        presses: (frame, milliseconds from the key's event to the frame's drawing).
        dropped: Frames that were executed and not drawn.
    """

    presses: list[tuple[int, float]] = field(default_factory=list)
    dropped: list[int] = field(default_factory=list)

    def to_json(self) -> dict[str, Any]:
        """Return the conditions as data."""
        return {
            "presses": [[frame, ms] for frame, ms in self.presses],
            "dropped": list(self.dropped),
        }

    @classmethod
    def from_conditions(cls, conditions: Mapping[str, Any]) -> Self | None:
        """Read them from a recording's conditions; None if it has none that can be read.

        Conditions come with imported files, so that nothing can be taken for granted.
        """
        try:
            stored = _Stored.model_validate(conditions.get(KEY))
        except ValidationError:
            return None
        return cls(**{name: getattr(stored, name) for name in _Stored.model_fields})

    def latency(self, n_frames: int) -> Latency:
        """Sum up how late a game of so many frames was seen."""
        times = [ms for _, ms in self.presses]
        p95_ms = _nearest_rank(times, 0.95)
        is_late = p95_ms is not None and p95_ms > BAD_P95_MS
        return Latency(
            presses=len(times),
            p50_ms=_nearest_rank(times, 0.5),
            p95_ms=p95_ms,
            frames_dropped=len(self.dropped),
            is_bad=is_late or len(self.dropped) > BAD_DROPPED_SHARE * n_frames,
        )


class _Stored(BaseModel):
    model_config = ConfigDict(extra="forbid", allow_inf_nan=False)

    presses: list[tuple[int, float]]
    dropped: list[int]


def _nearest_rank(values: Sequence[float], share: float) -> float | None:
    """The smallest value that so large a share of the values does not exceed."""
    if not values:
        return None
    return sorted(values)[max(0, math.ceil(share * len(values)) - 1)]
