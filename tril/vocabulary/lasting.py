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
