"""What the reward network gives for one observation under many masks, without starting over.

A mask of 3x3 pixels reaches at most 3x3 of the first layer's 26x26 outputs, and those at most 4x4
of the second's 11x11. Only these are computed anew. Of the third layer nearly half changes, of the
fourth up to all: they are computed whole.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import torch
from torch import Tensor
from torch.nn import functional as F

from trainer.reward.model import RewardNetwork
from tril.game.space_invaders import BACKGROUND

PATCH = 3
"""Side of the mask, in pixels."""

_KERNEL, _STRIDE = 7, 3
_REACH = 3
"""Outputs of the first layer, per side, that one mask reaches at most."""

_SECOND_KERNEL, _SECOND_STRIDE = 5, 2
_SECOND_REACH = 4
"""Outputs of the second layer, per side, that one mask reaches at most."""

_WINDOW = _SECOND_STRIDE * (_SECOND_REACH - 1) + _SECOND_KERNEL + 1
"""Of the first layer, per side: what those see (11), and one more, which none of them sees.

With it the 3x3 lie inside a window also at the lower and right edge, where a stride of 2 leaves
the last output of the first layer unseen.
"""


class OccludedOutputs:
    """A network's outputs for one observation, parts of which are hidden.

    Args:
        network: The network; call under torch.inference_mode.
        observation: float32 (4, 84, 84), 0 to 255.

    Attributes:
        plain: What the network gives without a mask, float32 (1,).
    """

    def __init__(self, network: RewardNetwork, observation: Tensor) -> None:
        self._network = network
        self._observation = observation
        first = network.first(observation[None])
        activated = F.leaky_relu(first)
        second = network.layers[1](activated)
        self.plain = network.after_second(second)
        self._second = second[0].permute(1, 2, 0).contiguous()
        # Views that hold a window for each place where it can begin: (place, place, 16, side, side)
        self._reached = _windows(first[0], _REACH, 1)
        self._seen = _windows(activated[0], _WINDOW, _SECOND_STRIDE)

    def at(self, positions: npt.NDArray[np.int64]) -> Tensor:
        """Return the output under a mask at each position, float32 (N,).

        Args:
            positions: int64 (N, 3): screen, and row and column of the mask's upper left pixel.
        """
        screens, rows, columns = (torch.from_numpy(part) for part in positions.T)
        out_rows = _first_reached(rows, _KERNEL, _STRIDE, len(self._reached))
        out_columns = _first_reached(columns, _KERNEL, _STRIDE, len(self._reached))
        change = self._change(screens, rows, columns, out_rows, out_columns)
        changed = self._reached[out_rows, out_columns] + change
        places = len(self._seen)
        second_rows = _first_reached(out_rows, _SECOND_KERNEL, _SECOND_STRIDE, places)
        second_columns = _first_reached(out_columns, _SECOND_KERNEL, _SECOND_STRIDE, places)
        seen = self._seen[second_rows, second_columns]
        _put(
            seen.permute(0, 2, 3, 1),
            F.leaky_relu(changed).permute(0, 2, 3, 1),
            out_rows - _SECOND_STRIDE * second_rows,
            out_columns - _SECOND_STRIDE * second_columns,
        )
        second = self._second.expand(len(positions), -1, -1, -1).clone()
        part = self._network.layers[1](seen.contiguous(memory_format=torch.channels_last))
        _put(second, part.permute(0, 2, 3, 1), second_rows, second_columns)
        return self._network.after_second(second.permute(0, 3, 1, 2))

    def _change(
        self,
        screens: Tensor,
        rows: Tensor,
        columns: Tensor,
        out_rows: Tensor,
        out_columns: Tensor,
    ) -> Tensor:
        """Return what masks add to the outputs of the first layer, float32 (N, 16, 3, 3).

        The layer is linear: a mask subtracts what its pixels (their difference from the
        background) contribute. Around each mask, that difference is cut out as wide as the outputs
        which it reaches can see, and run through the same convolution.

        Args:
            screens: int64 (N,).
            rows: int64 (N,): of the masks.
            columns: As rows.
            out_rows: int64 (N,): the first of the outputs that they reach.
            out_columns: As out_rows.
        """
        side = torch.arange(_STRIDE * (_REACH - 1) + _KERNEL)
        in_rows = _STRIDE * out_rows[:, None] + side
        in_columns = _STRIDE * out_columns[:, None] + side
        covered = _covered(rows, in_rows)[:, :, None] & _covered(columns, in_columns)[:, None, :]
        pixels = self._observation[
            screens[:, None, None], in_rows[:, :, None], in_columns[:, None, :]
        ]
        removed = torch.where(covered, BACKGROUND - pixels, torch.zeros(()))
        weight = self._network.layers[0].weight / 255.0
        n_outputs, n_screens = weight.shape[:2]
        per_screen = F.conv2d(
            removed[:, None],
            weight.transpose(0, 1).reshape(-1, 1, _KERNEL, _KERNEL),
            stride=_STRIDE,
        ).reshape(len(screens), n_screens, n_outputs, _REACH, _REACH)
        return per_screen[torch.arange(len(screens)), screens]


def _windows(values: Tensor, side: int, stride: int) -> Tensor:
    """Return all windows of (C, H, W) as a view (places, places, C, side, side)."""
    return values.unfold(1, side, stride).unfold(2, side, stride).permute(1, 2, 0, 3, 4)


def _first_reached(begin: Tensor, kernel: int, stride: int, n_places: int) -> Tensor:
    """Return where the outputs begin which see what lies from ``begin`` on.

    Args:
        begin: int64 (N,).
        kernel: Of the layer.
        stride: Of the layer.
        n_places: At how many places they can begin.
    """
    lowest = torch.div(begin - kernel + stride, stride, rounding_mode="floor")
    return lowest.clamp(0, n_places - 1)


def _covered(begin: Tensor, places: Tensor) -> Tensor:
    """Return which places, int64 (N, side), masks from ``begin`` on cover, bool (N, side)."""
    return (places >= begin[:, None]) & (places < begin[:, None] + PATCH)


def _put(into: Tensor, values: Tensor, rows: Tensor, columns: Tensor) -> None:
    """Write values (N, h, w, C) into (N, H, W, C), each from its row and column on."""
    height, width = values.shape[1:3]
    into[
        torch.arange(len(into))[:, None, None],
        (rows[:, None] + torch.arange(height))[:, :, None],
        (columns[:, None] + torch.arange(width))[:, None, :],
    ] = values
