"""The device that networks learn on: the CPU, or a GPU where there is a usable one.

The device of a network decides: callers send it observations and take its outputs back to the CPU,
where everything is drawn, played and stored. One code path serves all devices, and nothing is
copied on the CPU.
"""

from __future__ import annotations

import copy
import logging
import warnings

import torch
from torch import Tensor, nn
from torch.nn import functional as F

from tril.errors import Invalid

CPU = torch.device("cpu")

MAX_GRADIENT_DIFFERENCE = 0.02
"""Of a GPU's gradient from the CPU's, relative to its norm. TF32 alone causes 0.002 to 0.008, which
would be acceptable, but is switched off, see _configure_cudnn."""

log = logging.getLogger(__name__)


def device_of(network: nn.Module) -> torch.device:
    """Return the device of a network's parameters."""
    return next(network.parameters()).device


def forward_batch(device: torch.device) -> int:
    """Return the number of observations per forward pass.

    More than 256 do not fit into a CPU's caches and are slower; a GPU needs more to be busy.
    """
    return 256 if device == CPU else 8192


def learning_device(setting: str) -> torch.device:
    """Return the device to learn on, and log it.

    Args:
        setting: "cpu", "cuda", or "auto" for a GPU if there is one whose gradients agree with the
            CPU's; the reason against it is logged.

    Raises:
        Invalid: The setting is "cuda" and there is no usable GPU.
    """
    if setting == "cpu":
        return CPU
    problem = _gpu_problem()
    if problem is None:
        device = torch.device("cuda", torch.cuda.current_device())
        log.info("Networks learn on %s, %s.", device, torch.cuda.get_device_name(device))
        return device
    if setting == "cuda":
        raise Invalid(
            f"Learning can't use a GPU: {problem}. Set TRIL_LEARNING_DEVICE to auto or cpu, or"
            " install a build of PyTorch that supports this GPU."
        )
    log.info("Networks learn on the CPU, not on a GPU: %s.", problem)
    return CPU


def free_memory() -> None:
    """Return a GPU's unused memory to other programs."""
    if torch.cuda.is_initialized():  # type: ignore[no-untyped-call]
        torch.cuda.empty_cache()


def _gpu_problem() -> str | None:
    """Return why a GPU can't be used; None if it can."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        is_available = torch.cuda.is_available()
    if not is_available:
        # PyTorch reports a driver that is too old as a warning.
        return "; ".join(["PyTorch finds none", *(str(warning.message) for warning in caught)])
    _configure_cudnn()
    try:
        return compare_gradients(torch.device("cuda", torch.cuda.current_device()))
    except Exception as error:  # noqa: BLE001  Drivers fail in more ways than have a name.
        return f"it fails ({type(error).__name__}: {error})"


def _configure_cudnn() -> None:
    """Compute in full float32 precision and add gradients in a fixed order."""
    torch.backends.cudnn.allow_tf32 = False
    torch.backends.cudnn.deterministic = True


def compare_gradients(device: torch.device) -> str | None:
    """Compare a small network's gradients on a device with those on the CPU.

    Returns:
        How they differ; None if rounding explains the difference. Errors of the device propagate.
    """
    generator = torch.Generator().manual_seed(0)
    network = nn.Sequential(nn.Conv2d(4, 8, 8, 4), nn.ReLU(), nn.Flatten(), nn.Linear(3200, 2))
    with torch.no_grad():
        for parameter in network.parameters():
            parameter.copy_(torch.randn(parameter.shape, generator=generator) * 0.05)
    inputs = torch.rand((16, 4, 84, 84), generator=generator)
    gradients: list[list[Tensor]] = []
    for place in (CPU, device):
        moved = copy.deepcopy(network).to(place)
        F.softplus(moved(inputs.to(place))).sum().backward()  # type: ignore[no-untyped-call]
        gradients.append([p.grad.cpu() for p in moved.parameters() if p.grad is not None])
    for expected, actual in zip(*gradients, strict=True):
        difference = float((expected - actual).norm() / expected.norm())
        if not difference <= MAX_GRADIENT_DIFFERENCE:
            return f"its gradients differ from the CPU's by {difference:.1%}"
    return None
