"""A quick attention map: the gradient of R times the input (Shrikumar et al. 2016).

To first order it is the change of R if one pixel became background, so it estimates the map by
occlusion from one pass through the network and back. docs/benchmarks.md compares the two.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import torch

from trainer.reward.model import RewardModel
from tril.game.observation import check_observations
from tril.game.space_invaders import BACKGROUND


def gradient_map(model: RewardModel, observation: npt.NDArray[np.uint8]) -> npt.NDArray[np.float32]:
    """Return the magnitude of R's gradient times the pixel's difference from the background.

    Args:
        model: The reward model, on the CPU; its raw R is used.
        observation: uint8 (4, 84, 84).

    Returns:
        float32 (4, 84, 84), non-negative, one map per screen; their sum is shown.

    Raises:
        ValueError: The observation has another shape or dtype.
    """
    check_observations(observation[None])
    pixels = torch.from_numpy(observation[None].astype(np.float32)).requires_grad_(True)
    with torch.enable_grad():
        outputs = [member.after_first(member.first(pixels)) for member in model.members]
        (gradient,) = torch.autograd.grad(model.combine(outputs).sum(), pixels)
    change = (gradient * (pixels.detach() - BACKGROUND)).abs()
    return change[0].numpy()
