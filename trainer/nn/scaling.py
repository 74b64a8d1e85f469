"""Layers scaled on data before they learn."""

from __future__ import annotations

from collections.abc import Callable, Iterable

import numpy as np
import numpy.typing as npt
import torch
from torch import Tensor, nn

from trainer.nn.devices import device_of
from trainer.nn.screens import channels_last_screens

N_SCREENS = 256
"""Observations that layers are scaled on."""
LEAST_DEVIATION = 1e-2
"""Units that hardly vary are not scaled to a variance of 1."""


@torch.no_grad()
def scale_layers(
    layers: Iterable[nn.Conv2d | nn.Linear],
    activation: Callable[[Tensor], Tensor],
    observations: npt.NDArray[np.uint8],
) -> None:
    """Scale and shift each layer so that its units have mean 0 and variance 1 on observations.

    Layer-sequential unit-variance initialisation (Mishkin and Matas 2016, section 2), without its
    orthogonal weights and with means. Where the background is bright, common initialisations give
    hidden layers that are nearly the same on all screens, and learning hardly begins.

    Args:
        layers: From the first on, which takes observations divided by 255; changed in place.
        activation: Between layers.
        observations: uint8 (N, 4, 84, 84).
    """
    layers = list(layers)
    screens = channels_last_screens(observations).to(device_of(layers[0]))
    inputs = screens.to(torch.float32, memory_format=torch.channels_last) / 255.0
    for layer in layers:
        if isinstance(layer, nn.Linear):
            inputs = inputs.flatten(1)
        values = layer(inputs)
        # Convolutions: (N, channels, height, width), linear layers: (N, units).
        over = [dim for dim in range(values.dim()) if dim != 1]
        deviation, mean = torch.std_mean(values, over, keepdim=True)
        deviation = deviation.clamp_min(LEAST_DEVIATION)
        layer.weight.div_(deviation.reshape(-1, *[1] * (layer.weight.dim() - 1)))
        assert layer.bias is not None
        layer.bias.sub_(mean.flatten()).div_(deviation.flatten())
        inputs = activation((values - mean) / deviation)
