"""Where networks learn: on the processor, or on a GPU where there is one.

A network's own device decides. What asks a network sends it the observations and takes the answers
back; what is drawn, played, kept and shown stays on the processor. So there is one way for all
devices, and on the processor nothing is copied.
"""

from __future__ import annotations

import copy
import logging

import torch
from torch import Tensor, nn
from torch.nn import functional as F

from tril.errors import Invalid

CPU = torch.device("cpu")

logger = logging.getLogger(__name__)


def device_of(network: nn.Module) -> torch.device:
    """Return where a network's weights are."""
    return next(network.parameters()).device


def forward_batch(device: torch.device) -> int:
    """Return how many observations a forward pass without gradients takes at once.

    More than 256 leave a processor's caches and are slower; a GPU is not filled by so few.
    """
    return 256 if device == CPU else 8192


def learning_device(wanted: str) -> torch.device:
    """Return where networks learn.

    Args:
        wanted: "cpu", "cuda", or "auto" for a GPU if there is one that is usable: one whose
            gradients are the processor's. What speaks against it is logged.

    Raises:
        Invalid: "cuda" is wanted and there is no usable GPU.
    """
    if wanted == "cpu":
        return CPU
    obstacle = _obstacle()
    if obstacle is None:
        return torch.device("cuda")
    if wanted == "cuda":
        raise Invalid(
            f"Learning can't use a GPU: {obstacle}. Set TRIL_LEARNING_DEVICE to auto or cpu, or"
            " install a build of PyTorch that knows this GPU."
        )
    if torch.cuda.is_available():
        logger.warning("Learning uses the processor instead of the GPU: %s.", obstacle)
    return CPU


def _obstacle() -> str | None:
    """Return why a GPU can't be used; None if it can."""
    if not torch.cuda.is_available():
        return "PyTorch finds none"
    try:
        return compare_gradients(torch.device("cuda"))
    except (RuntimeError, AssertionError) as error:
        return f"it fails ({error})"


def compare_gradients(device: torch.device) -> str | None:
    """Compute a small network's gradients there and on the processor.

    Returns:
        How they differ; None if they don't by more than rounding makes of it.

    Raises:
        RuntimeError, AssertionError: The device can't compute them.
    """
    generator = torch.Generator().manual_seed(0)
    network = nn.Sequential(nn.Conv2d(4, 8, 8, 4), nn.ReLU(), nn.Flatten(), nn.Linear(3200, 2))
    with torch.no_grad():
        for parameter in network.parameters():
            parameter.copy_(torch.randn(parameter.shape, generator=generator) * 0.05)
    inputs = torch.rand((16, 4, 84, 84), generator=generator)
    gradients: list[list[Tensor]] = []
    for place in (CPU, device):
        there = copy.deepcopy(network).to(place)
        F.softplus(there(inputs.to(place))).sum().backward()  # type: ignore[no-untyped-call]
        gradients.append([p.grad.cpu() for p in there.parameters() if p.grad is not None])
    for expected, found in zip(*gradients, strict=True):
        if not torch.allclose(expected, found, rtol=0.02, atol=0.002 * float(expected.abs().max())):
            return f"its gradients differ by up to {float((expected - found).abs().max()):.2g}"
    return None
