"""In which numbers networks learn: half as long ones where the device is faster with them.

Mixed precision (Micikevicius et al. 2018) with bfloat16: convolutions and hidden layers multiply
in 16 bits and add in 32; weights, losses, the optimizer and the last layers stay in 32, so that
nothing has to be rescaled. Rewards and evaluations are always computed in 32 bits.
"""

from __future__ import annotations

from contextlib import AbstractContextManager, nullcontext
from enum import StrEnum

import torch

from trainer.nn.devices import CPU


class Precision(StrEnum):
    """The numbers that a policy's layers multiply while it learns."""

    FLOAT32 = "float32"
    BFLOAT16 = "bfloat16"

    @classmethod
    def of(cls, wanted: str, device: torch.device = CPU) -> Precision:
        """Return the precision wanted; "auto" is the shorter one where the device multiplies it."""
        if wanted != "auto":
            return cls(wanted)
        return cls.BFLOAT16 if _multiplies_bfloat16(device) else cls.FLOAT32

    def multiplying(self, device: torch.device = CPU) -> AbstractContextManager[object]:
        """Return a context in which networks multiply these numbers on that device."""
        if not torch.amp.is_autocast_available(device.type):
            return nullcontext()
        is_half = self is Precision.BFLOAT16
        return torch.autocast(device.type, dtype=torch.bfloat16, enabled=is_half)


def layer_dtype(device: torch.device = CPU) -> torch.dtype:
    """Return the numbers that layers multiply now, for what is made to be their input."""
    if torch.amp.is_autocast_available(device.type) and torch.is_autocast_enabled(device.type):
        return torch.get_autocast_dtype(device.type)
    return torch.float32


def _multiplies_bfloat16(device: torch.device) -> bool:
    """Tell whether the device has instructions for it; without them it is slower."""
    if device.type == "cuda":
        return bool(torch.cuda.is_bf16_supported(including_emulation=False))
    has = getattr(torch.cpu, "_is_avx512_bf16_supported", None)
    return bool(has and has())
