"""Where networks learn: on the processor, or on a GPU where there is one.

A network's own device decides. What asks a network sends it the observations and takes the answers
back; what is drawn, played, kept and shown stays on the processor. So there is one way for all
devices, and on the processor nothing is copied.
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

LARGEST_DIFFERENCE = 0.02
"""Of a gradient on a GPU from the processor's, as a share of its norm. TF32 makes 0.002 to 0.008
of it, which is not wrong; it is switched off all the same, see _settle."""

log = logging.getLogger(__name__)


def device_of(network: nn.Module) -> torch.device:
    """Return where a network's weights are."""
    return next(network.parameters()).device


def forward_batch(device: torch.device) -> int:
    """Return how many observations a forward pass takes at once.

    More than 256 leave a processor's caches and are slower; a GPU is not filled by so few.
    """
    return 256 if device == CPU else 8192


def learning_device(wanted: str) -> torch.device:
    """Return where networks learn, and say so in the log.

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
        device = torch.device("cuda", torch.cuda.current_device())
        log.info("Networks learn on %s, %s.", device, torch.cuda.get_device_name(device))
        return device
    if wanted == "cuda":
        raise Invalid(
            f"Learning can't use a GPU: {obstacle}. Set TRIL_LEARNING_DEVICE to auto or cpu, or"
            " install a build of PyTorch that knows this GPU."
        )
    log.info("Networks learn on the processor, not on a GPU: %s.", obstacle)
    return CPU


def free_memory() -> None:
    """Give a GPU's memory that nothing uses any more back to other programs."""
    if torch.cuda.is_initialized():  # type: ignore[no-untyped-call]
        torch.cuda.empty_cache()


def _obstacle() -> str | None:
    """Return why a GPU can't be used; None if it can."""
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        is_there = torch.cuda.is_available()
    if not is_there:
        # A driver that is too old is told as a warning.
        return "; ".join(["PyTorch finds none", *(str(one.message) for one in told)])
    _settle()
    try:
        return compare_gradients(torch.device("cuda", torch.cuda.current_device()))
    except Exception as error:  # noqa: BLE001  Drivers fail in more ways than have a name.
        return f"it fails ({type(error).__name__}: {error})"


def _settle() -> None:
    """Let a GPU multiply 32-bit numbers as such, and add gradients in one order."""
    torch.backends.cudnn.allow_tf32 = False
    torch.backends.cudnn.deterministic = True


def compare_gradients(device: torch.device) -> str | None:
    """Compute a small network's gradients there and on the processor.

    Returns:
        How they differ; None if they don't by more than rounding makes of it. What the device
        raises is passed on.
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
        difference = float((expected - found).norm() / expected.norm())
        if not difference <= LARGEST_DIFFERENCE:
            return f"its gradients differ from the processor's by {difference:.1%}"
    return None
