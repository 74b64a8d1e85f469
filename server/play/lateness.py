"""How late the frames of a process's games begin. Pure."""

from __future__ import annotations

import math

BIN_MS = 0.25
N_BINS = 256
"""The last bin holds all that was later: 63.75 ms are almost four frames."""


class Lateness:
    """A histogram of milliseconds between a frame's deadline and the moment it began.

    Adding to it costs a microsecond, whatever was added before.
    """

    def __init__(self) -> None:
        self._counts = [0] * N_BINS

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

    def add(self, counts: list[int]) -> None:
        """Add another histogram's counts."""
        self._counts = [a + b for a, b in zip(self._counts, counts, strict=True)]

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

    def take(self) -> Lateness:
        """Return what was counted and begin anew."""
        taken = Lateness()
        taken._counts, self._counts = self._counts, taken._counts
        return taken
