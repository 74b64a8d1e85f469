"""How a game was played: latency, slow motion, single steps and pauses. Pure."""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Annotated, Any, Self

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, ValidationError

from tril.analysis.summary import Policy
from tril.games.base import MAX_FRAMES
from tril.store.training.evaluations import ActionSelection

KEY = "play"
"""The key of a recording's conditions that holds these."""

FULL_SPEED_PERCENT = 100
SLOWEST_PERCENT = 25

MAX_ENTRIES = 12_000
"""Bound on the lists that a page's messages lengthen: 3 minutes of a press in every frame."""

BAD_P95_MS = 100.0
"""Six frames at 60 Hz; people steer poorly beyond that."""
BAD_DROPPED_SHARE = 0.05
"""One frame in twenty that was not drawn is visible as stutter."""


@dataclass(frozen=True)
class Latency:
    """Latency of a game as its player saw it.

    Attributes:
        presses: Number of timed key presses.
        p50_ms: Median (nearest rank) of the milliseconds from a key's event to the drawing of the
            first frame executed with it; None without presses.
        p95_ms: 95th percentile of the same.
        frames_dropped: Frames that were executed and not drawn.
        is_bad: Whether presses were too late or too many frames dropped to play well.
    """

    presses: int
    p50_ms: float | None
    p95_ms: float | None
    frames_dropped: int
    is_bad: bool


class BegunBy(BaseModel):
    """The policy that played the first frames of a game, before a person took over.

    Attributes:
        run_id: Run of the policy.
        policy: "imitator" or "clone".
        action_selection: Action selection of the policy.
        frames: Number of frames that the policy played, including an opening.
    """

    model_config = ConfigDict(extra="forbid")

    run_id: Annotated[str, Field(pattern=r"^[0-9a-f-]{36}$")]
    policy: Policy
    action_selection: ActionSelection
    frames: Annotated[int, Field(ge=1, le=MAX_FRAMES)]


Percent = Annotated[int, Field(ge=SLOWEST_PERCENT, le=FULL_SPEED_PERCENT)]
_Frames = Annotated[list[int], Field(max_length=MAX_FRAMES)]


def _increasing(speeds: list[tuple[int, int]]) -> list[tuple[int, int]]:
    if any(frame >= after for (frame, _), (after, _) in pairwise(speeds)):
        raise ValueError("Expected one speed per frame, in order of frames.")
    return speeds


class PlayConditions(BaseModel):
    """How a game was played, by frame, so that a rewind can remove what came after a frame.

    Attributes:
        presses: (frame, milliseconds from the key's event to the frame's drawing).
        dropped: Frames that were executed and not drawn.
        speeds: (frame, percent of 60 Hz), frames strictly increasing: the speed after this frame;
            100 at first.
        single_steps: Frames that were executed one at a time.
        pauses: Frames after which the player paused.
        begun_by: The policy that a person took the game over from, if any.
    """

    model_config = ConfigDict(extra="forbid", allow_inf_nan=False)

    presses: Annotated[list[tuple[int, float]], Field(max_length=MAX_ENTRIES)] = []
    dropped: _Frames = []
    speeds: Annotated[
        list[tuple[Annotated[int, Field(ge=0, le=MAX_FRAMES)], Percent]],
        Field(max_length=MAX_FRAMES + 1),
        AfterValidator(_increasing),
    ] = []
    single_steps: _Frames = []
    pauses: Annotated[list[int], Field(max_length=MAX_ENTRIES)] = []
    begun_by: BegunBy | None = None

    @classmethod
    def from_conditions(cls, conditions: Mapping[str, Any]) -> Self | None:
        """Parse a recording's conditions; None if they are missing, malformed or too many.

        Imported files carry conditions of any origin, so none of it is trusted.
        """
        try:
            return cls.model_validate(conditions.get(KEY))
        except ValidationError:
            return None

    def to_conditions(self) -> dict[str, Any]:
        """Return these as a part of a recording's conditions, JSON-serialisable."""
        return {KEY: self.model_dump(mode="json", exclude_none=True)}

    @property
    def speed_percent(self) -> int:
        """The current speed."""
        return self.speeds[-1][1] if self.speeds else FULL_SPEED_PERCENT

    def set_speed(self, frame: int, percent: int) -> None:
        """Change the speed after a frame; replaces a change at the same frame."""
        if self.speeds and self.speeds[-1][0] == frame:
            self.speeds.pop()
        if percent != self.speed_percent:
            self.speeds.append((frame, percent))

    def note_press(self, frame: int, latency_ms: float) -> None:
        """Record a press's latency, unless in slow motion or single steps, which distort it."""
        is_normal = frame not in self.single_steps and self._speed_at(frame) == FULL_SPEED_PERCENT
        if is_normal and len(self.presses) < MAX_ENTRIES:
            self.presses.append((frame, latency_ms))

    def note_pause(self, frame: int) -> None:
        """Record that the player paused after a frame."""
        if len(self.pauses) < MAX_ENTRIES:
            self.pauses.append(frame)

    def until(self, frame: int) -> Self:
        """Return the conditions of the frames up to this one, keeping the current speed."""
        conditions = type(self)(
            presses=[(at, ms) for at, ms in self.presses if at <= frame],
            dropped=[at for at in self.dropped if at <= frame],
            speeds=[(at, percent) for at, percent in self.speeds if at < frame],
            single_steps=[at for at in self.single_steps if at <= frame],
            pauses=[at for at in self.pauses if at <= frame],
            begun_by=self._begun_by_until(frame),
        )
        conditions.set_speed(frame, self.speed_percent)
        return conditions

    def _begun_by_until(self, frame: int) -> BegunBy | None:
        if self.begun_by is None or frame == 0:
            return None
        return self.begun_by.model_copy(update={"frames": min(frame, self.begun_by.frames)})

    def slowest_percent(self, n_frames: int) -> int:
        """Return the slowest speed at which any of the first ``n_frames`` frames was executed."""
        executed = (percent for frame, percent in self.speeds if frame < n_frames)
        return min(executed, default=FULL_SPEED_PERCENT)

    def _speed_at(self, frame: int) -> int:
        """Return the speed at which a frame was executed."""
        n_before = bisect_left(self.speeds, frame, key=lambda change: change[0])
        return self.speeds[n_before - 1][1] if n_before else FULL_SPEED_PERCENT

    def latency(self, n_frames: int) -> Latency:
        """Summarise the latency of a game of ``n_frames`` frames."""
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


def _nearest_rank(values: Sequence[float], share: float) -> float | None:
    """Return the smallest value that at least this share of the values does not exceed."""
    if not values:
        return None
    return sorted(values)[max(0, math.ceil(share * len(values)) - 1)]
