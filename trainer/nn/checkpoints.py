"""Checkpoints as safetensors files: named tensors and text, nothing pickled."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import torch
from safetensors import SafetensorError
from safetensors.torch import load, save
from torch import Tensor, nn

from tril.errors import Invalid
from tril.files.artifact_store import write_whole

_METADATA, _DIGEST = "__metadata__", "sha256"


class CheckpointDamaged(Invalid):
    """A checkpoint that is not as it was written.

    Attributes:
        path: The file.
    """

    def __init__(self, path: Path, reason: object) -> None:
        super().__init__(f"The checkpoint {path} can't be read: {reason}.")
        self.path = path


class NotFinite(Invalid):
    """A training whose numbers have become infinite or undefined."""


def check_finite(quantity: str, *tensors: Tensor) -> None:
    """Refuse tensors with infinite or undefined numbers; raises NotFinite.

    Args:
        quantity: Name of the tensors, for the message.
        *tensors: The tensors; those of integers are always finite.
    """
    if all(tensor.isfinite().all() for tensor in tensors):
        return
    raise NotFinite(
        f"Learning has diverged: the {quantity} is no longer a finite number. What was saved before"
        " is kept. Begin a new training with lower learning rates or another scale of the reward."
    )


def save_tensors(path: Path, tensors: Mapping[str, Tensor], metadata: dict[str, str]) -> None:
    """Write tensors and text to a file with a digest of both, which is replaced as a whole.

    Raises:
        NotFinite: A number is infinite or undefined. The file stays as it was.
    """
    check_finite("network", *tensors.values())
    contiguous = {name: t.contiguous() for name, t in tensors.items()}
    metadata = metadata | {_DIGEST: _digest(save(contiguous, metadata))}
    write_whole(path, save(contiguous, metadata))


def load_tensors(path: Path) -> tuple[dict[str, Tensor], dict[str, str]]:
    """Load tensors and text that ``save_tensors`` wrote.

    Raises:
        SafetensorError: The file is not in this format, or is not as it was written. Files of
            earlier versions have no digest.
    """
    content = path.read_bytes()
    tensors = load(content)
    metadata: dict[str, str] = _header_of(content).get(_METADATA, {})
    written = metadata.pop(_DIGEST, None)
    if written is not None and written != _digest(content):
        raise SafetensorError("it was damaged after it had been written")
    return tensors, metadata


def _header_of(content: bytes) -> dict[str, Any]:
    """Return the header of a safetensors file: its length in eight bytes, then JSON."""
    header: dict[str, Any] = json.loads(content[8 : 8 + int.from_bytes(content[:8], "little")])
    return header


def _digest(content: bytes) -> str:
    """Return the SHA-256 digest of a safetensors file's header, but for the digest, and data."""
    header = _header_of(content)
    header.get(_METADATA, {}).pop(_DIGEST, None)
    digest = hashlib.sha256(json.dumps(header, sort_keys=True).encode())
    digest.update(memoryview(content)[8 + int.from_bytes(content[:8], "little") :])
    return digest.hexdigest()


def prefixed(prefix: str, tensors: Mapping[str, Tensor], separator: str = "/") -> dict[str, Tensor]:
    """Return the tensors with a prefix to their names."""
    return {f"{prefix}{separator}{name}": tensor for name, tensor in tensors.items()}


def split_by_prefix(
    tensors: Mapping[str, Tensor], separator: str = "/"
) -> dict[str, dict[str, Tensor]]:
    """Group tensors by their prefix, the inverse of ``prefixed``."""
    groups: dict[str, dict[str, Tensor]] = {}
    for path, tensor in tensors.items():
        prefix, _, name = path.partition(separator)
        groups.setdefault(prefix, {})[name] = tensor
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
    groups = split_by_prefix(tensors, separator)
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
