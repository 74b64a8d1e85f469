"""How late the frames of a process's games begin. Pure."""

from __future__ import annotations

import math
from collections.abc import Sequence

BIN_MS = 0.25
LATE_MS = 8.0
"""Half a frame: when frames begin later than this, they begin to pile up."""
N_BINS = 256
"""The last bin holds all that was later: 63.75 ms are almost four frames."""


class Lateness:
    """A histogram of milliseconds between a frame's deadline and the moment it began.

    Adding to it costs a microsecond, whatever was added before.

    Args:
        counts: How many frames there are in each bin already; none if left out.
    """

    def __init__(self, counts: Sequence[int] = (0,) * N_BINS) -> None:
        if len(counts) != N_BINS:
            raise ValueError(f"Expected {N_BINS} bins, got {len(counts)}.")
        self._counts = list(counts)

    @property
    def n_frames(self) -> int:
        """How many frames were counted."""
        return sum(self._counts)

    @property
    def counts(self) -> list[int]:
        """How many frames there are in each bin of a quarter of a millisecond, from 0 on."""
        return list(self._counts)

    def note(self, late_s: float) -> None:
        """Count a frame that began so many seconds after its deadline."""
        self._counts[min(N_BINS - 1, max(0, int(1000 * late_s / BIN_MS)))] += 1

    def __add__(self, other: Lateness) -> Lateness:
        return Lateness([a + b for a, b in zip(self._counts, other._counts, strict=True)])

    def __sub__(self, earlier: Lateness) -> Lateness:
        return Lateness([a - b for a, b in zip(self._counts, earlier._counts, strict=True)])

    def percentile_ms(self, share: float) -> float | None:
        """Return what so large a share of the frames was not later than, in whole bins.

        Args:
            share: From 0 to 1, e.g. 0.99.

        Returns:
            Milliseconds, None without frames.
        """
        wanted = max(1, math.ceil(share * self.n_frames))
        seen = 0
        for n, count in enumerate(self._counts, start=1):
            seen += count
            if seen >= wanted:
                return n * BIN_MS
        return None


class Complaints:
    """Says in words when frames begin too late.

    Args:
        lateness: What is added to all the time.
    """

    def __init__(self, lateness: Lateness) -> None:
        self._lateness = lateness
        self._told = Lateness()

    def since_last(self, n_games: int) -> str | None:
        """Return a complaint about what came since the last call, None if all was well.

        Args:
            n_games: How many games this process has.
        """
        recent, self._told = self._lateness - self._told, self._lateness + Lateness()
        p99_ms = recent.percentile_ms(0.99)
        if p99_ms is None or p99_ms <= LATE_MS:
            return None
        return (
            f"In the last minute one frame in a hundred began more than {p99_ms - BIN_MS:.0f} ms "
            f"late, with {n_games} games in this process. More server processes "
            "(TRIL_SERVER_PROCESSES, up to one per core), fewer games (TRIL_MAX_GAMES) or less "
            "other work help."
        )
