"""What looks changed for a while, as things that pass hide it for less."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

Mask = npt.NDArray[np.bool_]

LASTING_STEPS = 8
"""Half a second, for which a place has to look changed."""


def lasting(changed: Mask) -> Mask:
    """Return where something looks changed for a while from a step on, bool (n_steps, n_places).

    Args:
        changed: Where it looks changed, of the same shape.
    """
    lasts = changed.copy()
    for lag in range(1, LASTING_STEPS):
        lasts[:-lag] &= changed[lag:]
    return lasts


def missing_for_good(missing: Mask, waves: npt.NDArray[np.int64]) -> Mask:
    """Return where something is missing and does not come back, bool (n_steps, n_places).

    What dives out of a formation and flies back to its place is not gone meanwhile.

    Args:
        missing: Where it is missing, of the same shape.
        waves: Number of the wave of each step, int64 (n_steps,): in the next one all come back.
    """
    gone = np.zeros_like(missing)
    for wave in np.unique(waves):
        own = slice(*np.searchsorted(waves, [wave, wave + 1]))
        are_there = lasting(~missing[own])
        # Whether it lasts is not known, and the first of the next wave may be there already.
        are_there[max(len(are_there) - LASTING_STEPS + 1, 0) :] = False
        come_back = np.logical_or.accumulate(are_there[::-1])[::-1]
        gone[own] = lasting(missing[own]) & ~come_back
    return gone
