"""Outputs of the reward network for one observation under many occluding patches.

A patch of 3x3 pixels affects at most 3x3 of the first layer's 26x26 outputs, and those at most 4x4
of the second's 11x11. Only these are recomputed. Nearly half of the third layer changes and up to
all of the fourth, which are computed as a whole.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import torch
from torch import Tensor
from torch.nn import functional as F

from trainer.reward.model import RewardNetwork

PATCH = 3
"""Side of the patch, in pixels."""

_KERNEL, _STRIDE = 7, 3
_REACH = 3
"""Outputs of the first layer, per side, that one patch affects at most."""

_SECOND_KERNEL, _SECOND_STRIDE = 5, 2
_SECOND_REACH = 4
"""Outputs of the second layer, per side, that one patch affects at most."""

_WINDOW = _SECOND_STRIDE * (_SECOND_REACH - 1) + _SECOND_KERNEL + 1
"""Outputs of the first layer, per side, in the receptive field of those (11), and one more.

With it the window contains the 3x3 at the lower and right edge too, where a stride of 2 leaves the
last output of the first layer outside all receptive fields.
"""


class OccludedOutputs:
    """A network's outputs for one observation under occluding patches.

    Args:
        network: The network; call under torch.inference_mode.
        observation: float32 (4, 84, 84), 0 to 255.
        background: Gray of the screen's background, 0 to 255.

    Attributes:
        plain: The output without a patch, float32 (1,).
    """

    def __init__(self, network: RewardNetwork, observation: Tensor, background: int = 0) -> None:
        self._network = network
        self._background = background
        self._observation = observation
        first = network.first(observation[None])
        activated = F.leaky_relu(first)
        second = network.layers[1](activated)
        self.plain = network.after_second(second)
        self._second = second[0].permute(1, 2, 0).contiguous()
        # Views of a window for each place where it can begin: (place, place, 16, side, side).
        self._affected = _windows(first[0], _REACH, 1)
        self._fields = _windows(activated[0], _WINDOW, _SECOND_STRIDE)

    def at(self, positions: npt.NDArray[np.int64]) -> Tensor:
        """Return the output under a patch at each position, float32 (N,).

        Args:
            positions: int64 (N, 3): screen, and row and column of the patch's upper left pixel.
        """
        screens, rows, columns = (torch.from_numpy(part) for part in positions.T)
        out_rows = _first_affected(rows, _KERNEL, _STRIDE, len(self._affected))
        out_columns = _first_affected(columns, _KERNEL, _STRIDE, len(self._affected))
        change = self._change(screens, rows, columns, out_rows, out_columns)
        changed = self._affected[out_rows, out_columns] + change
        places = len(self._fields)
        second_rows = _first_affected(out_rows, _SECOND_KERNEL, _SECOND_STRIDE, places)
        second_columns = _first_affected(out_columns, _SECOND_KERNEL, _SECOND_STRIDE, places)
        fields = self._fields[second_rows, second_columns]
        _put(
            fields.permute(0, 2, 3, 1),
            F.leaky_relu(changed).permute(0, 2, 3, 1),
            out_rows - _SECOND_STRIDE * second_rows,
            out_columns - _SECOND_STRIDE * second_columns,
        )
        second = self._second.expand(len(positions), -1, -1, -1).clone()
        part = self._network.layers[1](fields.contiguous(memory_format=torch.channels_last))
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
        """Return the change of the first layer's outputs, float32 (N, 16, 3, 3).

        The layer is linear: a patch subtracts the contribution of the pixels under it, that is of
        their difference from the background. This difference is cut out around each patch, as large
        as the receptive field of the affected outputs, and convolved.

        Args:
            screens: int64 (N,).
            rows: int64 (N,), of the patches.
            columns: As rows.
            out_rows: int64 (N,), of the first affected outputs.
            out_columns: As out_rows.
        """
        side = torch.arange(_STRIDE * (_REACH - 1) + _KERNEL)
        in_rows = _STRIDE * out_rows[:, None] + side
        in_columns = _STRIDE * out_columns[:, None] + side
        covered = _covered(rows, in_rows)[:, :, None] & _covered(columns, in_columns)[:, None, :]
        pixels = self._observation[
            screens[:, None, None], in_rows[:, :, None], in_columns[:, None, :]
        ]
        removed = torch.where(covered, self._background - pixels, torch.zeros(()))
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


def _first_affected(begin: Tensor, kernel: int, stride: int, n_places: int) -> Tensor:
    """Return the first outputs whose receptive fields contain the input at ``begin``, int64 (N,).

    Args:
        begin: int64 (N,).
        kernel: Kernel size of the layer.
        stride: Stride of the layer.
        n_places: Number of places where a window of outputs can begin.
    """
    lowest = torch.div(begin - kernel + stride, stride, rounding_mode="floor")
    return lowest.clamp(0, n_places - 1)


def _covered(begin: Tensor, places: Tensor) -> Tensor:
    """Return the places, int64 (N, side), under patches at ``begin``, bool (N, side)."""
    return (places >= begin[:, None]) & (places < begin[:, None] + PATCH)


def _put(into: Tensor, values: Tensor, rows: Tensor, columns: Tensor) -> None:
    """Write values (N, h, w, C) into (N, H, W, C), each at its row and column."""
    height, width = values.shape[1:3]
    into[
        torch.arange(len(into))[:, None, None],
        (rows[:, None] + torch.arange(height))[:, :, None],
        (columns[:, None] + torch.arange(width))[:, None, :],
    ] = values
