"""Floating point precision of learning.

Mixed precision (Micikevicius et al. 2018) with bfloat16: convolutions and hidden layers multiply
in 16 bits and accumulate in 32; weights, losses, optimizer and output layers stay in 32, so that
no loss scaling is needed. Rewards and evaluations are always computed in 32 bits.
"""

from __future__ import annotations

from contextlib import AbstractContextManager, nullcontext
from enum import StrEnum

import torch

from trainer.nn.devices import CPU


class Precision(StrEnum):
    """The precision in which a policy's layers multiply while it learns."""

    FLOAT32 = "float32"
    BFLOAT16 = "bfloat16"

    @classmethod
    def of(cls, setting: str, device: torch.device = CPU) -> Precision:
        """Return the precision of a setting; "auto" is bfloat16 where the device multiplies it."""
        if setting != "auto":
            return cls(setting)
        return cls.BFLOAT16 if _multiplies_bfloat16(device) else cls.FLOAT32

    def autocast(self, device: torch.device = CPU) -> AbstractContextManager[object]:
        """Return a context in which layers on that device multiply in this precision."""
        if not torch.amp.is_autocast_available(device.type):
            return nullcontext()
        is_half = self is Precision.BFLOAT16
        return torch.autocast(device.type, dtype=torch.bfloat16, enabled=is_half)


def layer_dtype(device: torch.device = CPU) -> torch.dtype:
    """Return the dtype that layers multiply in at present, for their inputs."""
    if torch.amp.is_autocast_available(device.type) and torch.is_autocast_enabled(device.type):
        return torch.get_autocast_dtype(device.type)
    return torch.float32


def _multiplies_bfloat16(device: torch.device) -> bool:
    """Return whether the device has instructions for bfloat16; it is slower without them."""
    if device.type == "cuda":
        return bool(torch.cuda.is_bf16_supported(including_emulation=False))
    has = getattr(torch.cpu, "_is_avx512_bf16_supported", None)
    return bool(has and has())
