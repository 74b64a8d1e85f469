"""How a game was played: what its recording says of latency and of helps to play well. Pure."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Annotated, Any, Self

from pydantic import BaseModel, ConfigDict, Field, ValidationError

KEY = "play"
"""Under which a recording's conditions hold these."""

FULL_SPEED_PERCENT = 100
SLOWEST_PERCENT = 25

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
        speeds: (frame, percent of 60 Hz): the speed from after this frame on; 100 at first.
        single_steps: Frames that were executed one at a time.
        pauses: Frames after which the player paused.
    """

    presses: list[tuple[int, float]] = field(default_factory=list)
    dropped: list[int] = field(default_factory=list)
    speeds: list[tuple[int, int]] = field(default_factory=list)
    single_steps: list[int] = field(default_factory=list)
    pauses: list[int] = field(default_factory=list)

    @property
    def speed_percent(self) -> int:
        """The speed at present."""
        return self.speeds[-1][1] if self.speeds else FULL_SPEED_PERCENT

    def set_speed(self, frame: int, percent: int) -> None:
        """Go on at another speed after a frame."""
        if self.speeds and self.speeds[-1][0] == frame:
            self.speeds.pop()
        if percent != self.speed_percent:
            self.speeds.append((frame, percent))

    def note_press(self, frame: int, latency_ms: float) -> None:
        """Take note of a latency; slow motion's and single steps' would say nothing of the way."""
        if frame not in self.single_steps and self._speed_of(frame) == FULL_SPEED_PERCENT:
            self.presses.append((frame, latency_ms))

    def until(self, frame: int) -> Self:
        """Return the conditions of the frames up to this one; the present speed holds on."""
        kept = replace(
            self,
            presses=[(at, ms) for at, ms in self.presses if at <= frame],
            dropped=[at for at in self.dropped if at <= frame],
            speeds=[(at, percent) for at, percent in self.speeds if at < frame],
            single_steps=[at for at in self.single_steps if at <= frame],
            pauses=[at for at in self.pauses if at <= frame],
        )
        kept.set_speed(frame, self.speed_percent)
        return kept

    def slowest_percent(self, n_frames: int) -> int:
        """The slowest speed at which any of so many frames was executed."""
        return min(map(self._speed_of, self._beginnings(n_frames)), default=FULL_SPEED_PERCENT)

    def _beginnings(self, n_frames: int) -> list[int]:
        """The first frame of every stretch of one speed."""
        return [f for f in (1, *(frame + 1 for frame, _ in self.speeds)) if f <= n_frames]

    def _speed_of(self, frame: int) -> int:
        """The speed at which a frame was executed."""
        before = [percent for at, percent in self.speeds if at < frame]
        return before[-1] if before else FULL_SPEED_PERCENT

    def to_json(self) -> dict[str, Any]:
        """Return the conditions as data."""
        return {
            "presses": [[frame, ms] for frame, ms in self.presses],
            "dropped": list(self.dropped),
            "speeds": [[frame, percent] for frame, percent in self.speeds],
            "single_steps": list(self.single_steps),
            "pauses": list(self.pauses),
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


Percent = Annotated[int, Field(ge=SLOWEST_PERCENT, le=FULL_SPEED_PERCENT)]


class _Stored(BaseModel):
    model_config = ConfigDict(extra="forbid", allow_inf_nan=False)

    presses: list[tuple[int, float]]
    dropped: list[int]
    speeds: list[tuple[int, Percent]]
    single_steps: list[int]
    pauses: list[int]


def _nearest_rank(values: Sequence[float], share: float) -> float | None:
    """The smallest value that so large a share of the values does not exceed."""
    if not values:
        return None
    return sorted(values)[max(0, math.ceil(share * len(values)) - 1)]
