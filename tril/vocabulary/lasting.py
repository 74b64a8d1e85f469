"""What looks changed for a while, as things that pass hide it for less."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

Mask = npt.NDArray[np.bool_]

LASTING_STEPS = 8
"""Half a second, for which a place has to look changed."""
MOST_DIVING_STEPS = 120
"""Eight seconds: an item that comes back later was gone meanwhile."""
MOST_DIVING = 3
"""Items that come back within a second; more of them are a new wave."""


def lasting(changed: Mask) -> Mask:
    """Return where something looks changed for a while from a step on, bool (n_steps, n_places).

    Args:
        changed: Where it looks changed, of the same shape.
    """
    lasts = changed.copy()
    for lag in range(1, LASTING_STEPS):
        lasts[:-lag] &= changed[lag:]
    return lasts


def missing_for_good(missing: Mask) -> Mask:
    """Return where something is missing and does not soon come back, bool (n_steps, n_places).

    What dives out of a formation and flies back to its place is not gone meanwhile. Where many
    come back at once, as a new wave, all of them were gone.

    Args:
        missing: Where it is missing, of the same shape.
    """
    gone = lasting(missing)
    are_there = lasting(~missing)
    # Whether it would have lasted is not known at the end.
    are_there[max(len(are_there) - LASTING_STEPS + 1, 0) :] = False
    begins = are_there & ~np.roll(are_there, 1, 0)
    begins[:1] = False
    n_beginning = begins.sum(1)
    for step, place in np.argwhere(begins):
        before = np.flatnonzero(are_there[:step, place])
        last = int(before[-1]) if len(before) else -1
        around = slice(max(step - LASTING_STEPS, 0), step + LASTING_STEPS)
        if step - last <= MOST_DIVING_STEPS and n_beginning[around].sum() <= MOST_DIVING:
            gone[last + 1 : step, place] = False
    return gone
