"""Checkpoints as safetensors files: named tensors and text, nothing pickled."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import torch
from safetensors import safe_open
from safetensors.torch import save
from torch import Tensor, nn

from tril.files.artifact_store import write_whole


def save_tensors(path: Path, tensors: Mapping[str, Tensor], metadata: dict[str, str]) -> None:
    """Write tensors and text to a file, which is replaced as a whole."""
    write_whole(path, save({name: t.contiguous() for name, t in tensors.items()}, metadata))


def load_tensors(path: Path) -> tuple[dict[str, Tensor], dict[str, str]]:
    """Return what ``save_tensors`` wrote.

    Raises:
        SafetensorError: The file is not in this format.
    """
    with safe_open(str(path), framework="pt") as file:
        tensors = {name: file.get_tensor(name) for name in file.keys()}  # noqa: SIM118
        return tensors, file.metadata() or {}


def prefixed(prefix: str, tensors: Mapping[str, Tensor], separator: str = "/") -> dict[str, Tensor]:
    """Return the tensors with a prefix to their names."""
    return {f"{prefix}{separator}{name}": tensor for name, tensor in tensors.items()}


def by_prefix(tensors: Mapping[str, Tensor], separator: str = "/") -> dict[str, dict[str, Tensor]]:
    """Return the tensors grouped by the prefixes that ``prefixed`` gave them."""
    groups: dict[str, dict[str, Tensor]] = {}
    for name, tensor in tensors.items():
        prefix, _, rest = name.partition(separator)
        groups.setdefault(prefix, {})[rest] = tensor
    return groups


def training_tensors(
    network: nn.Module, optimizer: torch.optim.Optimizer, separator: str = "/"
) -> dict[str, Tensor]:
    """Return the state of a network and of the optimizer of its parameters."""
    state = optimizer_tensors(optimizer, list(network.parameters()))
    return prefixed("network", network.state_dict(), separator) | prefixed(
        "optimizer", state, separator
    )


def restore_training(
    network: nn.Module,
    optimizer: torch.optim.Optimizer,
    tensors: Mapping[str, Tensor],
    separator: str = "/",
) -> None:
    """Put a network and its optimizer into the state that ``training_tensors`` returned."""
    groups = by_prefix(tensors, separator)
    network.load_state_dict(groups["network"])
    restore_optimizer(optimizer, list(network.parameters()), groups.get("optimizer", {}))


def optimizer_tensors(
    optimizer: torch.optim.Optimizer, parameters: Sequence[nn.Parameter]
) -> dict[str, Tensor]:
    """Return an Adam optimizer's state, named by the parameter's index and the state's key."""
    return {
        f"{number}/{name}": value
        for number, parameter in enumerate(parameters)
        for name, value in optimizer.state.get(parameter, {}).items()
    }


def restore_optimizer(
    optimizer: torch.optim.Optimizer,
    parameters: Sequence[nn.Parameter],
    tensors: Mapping[str, Tensor],
) -> None:
    """Restore what ``optimizer_tensors`` returned, in the parameters' memory layout."""
    for name, tensor in tensors.items():
        number, _, key = name.partition("/")
        parameter = parameters[int(number)]
        if tensor.shape == parameter.shape:
            value = torch.empty_like(parameter).copy_(tensor)
        else:
            # The step count, which only the fused Adam wants on the parameters' device.
            value = tensor.to(parameter.device) if optimizer.defaults.get("fused") else tensor
        optimizer.state[parameter][key] = value.detach()
