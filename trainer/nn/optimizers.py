"""An Adam optimizer's state as plain tensors, for checkpoints without pickle."""

from __future__ import annotations

from collections.abc import Sequence

import torch
from torch import Tensor, nn


def optimizer_tensors(
    optimizer: torch.optim.Optimizer, parameters: Sequence[nn.Parameter]
) -> dict[str, Tensor]:
    """Return the optimizer's state of these parameters, by their place and the state's name."""
    return {
        f"{number}/{name}": value
        for number, parameter in enumerate(parameters)
        for name, value in optimizer.state.get(parameter, {}).items()
    }


def restore_optimizer(
    optimizer: torch.optim.Optimizer,
    parameters: Sequence[nn.Parameter],
    tensors: dict[str, Tensor],
) -> None:
    """Fill in what ``optimizer_tensors`` returned, laid out in memory as the parameters are."""
    for name, tensor in tensors.items():
        number, _, key = name.partition("/")
        parameter = parameters[int(number)]
        if tensor.shape == parameter.shape:
            kept = torch.empty_like(parameter).copy_(tensor)
        else:
            # The number of steps, which Adam wants beside the parameters only if it is fused.
            kept = tensor.to(parameter.device) if optimizer.defaults.get("fused") else tensor
        optimizer.state[parameter][key] = kept.detach()
