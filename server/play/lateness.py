"""How late the frames of a process's games begin."""

from __future__ import annotations

import logging
import math
from collections.abc import Sequence

_LOG = logging.getLogger(__name__)

BIN_MS = 0.25
LATE_MS = 8.0
"""Half a frame: beyond this, frames begin to pile up."""
N_BINS = 256
"""The last bin also holds all later frames: 63.75 ms are almost four frames."""


class Lateness:
    """A histogram of the milliseconds from a frame's deadline to its actual begin.

    Args:
        counts: Initial number of frames in each bin; empty if left out.
    """

    def __init__(self, counts: Sequence[int] = (0,) * N_BINS) -> None:
        if len(counts) != N_BINS:
            raise ValueError(f"Expected {N_BINS} bins, got {len(counts)}.")
        self._counts = list(counts)

    @property
    def n_frames(self) -> int:
        """Total number of frames."""
        return sum(self._counts)

    @property
    def counts(self) -> list[int]:
        """Number of frames in each bin of a quarter of a millisecond, from 0 on."""
        return list(self._counts)

    def note(self, late_s: float) -> None:
        """Add a frame that began this many seconds after its deadline."""
        self._counts[min(N_BINS - 1, max(0, int(1000 * late_s / BIN_MS)))] += 1

    def __add__(self, other: Lateness) -> Lateness:
        return Lateness([a + b for a, b in zip(self._counts, other._counts, strict=True)])

    def __sub__(self, earlier: Lateness) -> Lateness:
        return Lateness([a - b for a, b in zip(self._counts, earlier._counts, strict=True)])

    def percentile_ms(self, share: float) -> float | None:
        """Return the upper edge, in ms, of the bin that holds a percentile; None without frames.

        Args:
            share: 0 to 1, e.g. 0.99.
        """
        rank = max(1, math.ceil(share * self.n_frames))
        n_seen = 0
        for n, count in enumerate(self._counts, start=1):
            n_seen += count
            if n_seen >= rank:
                return n * BIN_MS
        return None


class LatenessLog:
    """Logs a warning when frames begin too late."""

    def __init__(self, lateness: Lateness) -> None:
        self._lateness = lateness
        self._logged = Lateness()

    def report(self, n_games: int) -> None:
        """Log a warning if frames since the last report were late and games are still open."""
        recent, self._logged = self._lateness - self._logged, self._lateness + Lateness()
        p99_ms = recent.percentile_ms(0.99)
        if n_games == 0 or p99_ms is None or p99_ms <= LATE_MS:
            return
        _LOG.warning(
            "In the last minute one frame in a hundred began more than %.0f ms late, with %d games "
            "in this process. More server processes (TRIL_SERVER_PROCESSES, up to one per core), "
            "fewer games (TRIL_MAX_GAMES) or less other work help.",
            p99_ms - BIN_MS,
            n_games,
        )
