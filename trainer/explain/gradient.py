"""A quick attention map: gradient times input (Shrikumar et al. 2016).

To first order it is the change of R, or of an action's odds, if one pixel became background, so it
estimates the map by occlusion from one pass through the network and back. docs/benchmarks.md
compares the two.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import torch

from trainer.explain.subject import Subject
from tril.play.observation import check_observations


def gradient_map(
    subject: Subject, observation: npt.NDArray[np.uint8], background: int = 0
) -> npt.NDArray[np.float32]:
    """Return the magnitude of the gradient times the pixel's difference from the background.

    Args:
        subject: Subject to explain, on the CPU; of a reward model it is its raw R.
        observation: uint8 (4, 84, 84).
        background: Gray of the screen's background, 0 to 255.

    Returns:
        float32 (4, 84, 84), non-negative, one map per screen; their sum is shown.

    Raises:
        ValueError: The observation has another shape or dtype.
    """
    check_observations(observation[None])
    pixels = torch.from_numpy(observation[None].astype(np.float32)).requires_grad_(True)
    with torch.enable_grad():
        (gradient,) = torch.autograd.grad(subject.of_pixels(pixels).sum(), pixels)
    change = (gradient * (pixels.detach() - background)).abs()
    return change[0].numpy()
