"""In which numbers networks learn: half as long ones where the processor is faster with them.

Mixed precision (Micikevicius et al. 2018) with bfloat16: convolutions and hidden layers multiply
in 16 bits and add in 32; weights, losses, the optimizer and the last layers stay in 32, so that
nothing has to be rescaled. Rewards and evaluations are always computed in 32 bits.
"""

from __future__ import annotations

from contextlib import AbstractContextManager
from enum import StrEnum

import torch


class Precision(StrEnum):
    """The numbers that a policy's layers multiply while it learns."""

    FLOAT32 = "float32"
    BFLOAT16 = "bfloat16"

    @classmethod
    def of(cls, wanted: str) -> Precision:
        """Return the precision wanted; "auto" is the faster one of this processor."""
        if wanted != "auto":
            return cls(wanted)
        return cls.BFLOAT16 if _multiplies_bfloat16() else cls.FLOAT32

    def multiplying(self) -> AbstractContextManager[object]:
        """Return a context in which networks multiply these numbers."""
        is_half = self is Precision.BFLOAT16
        return torch.autocast("cpu", dtype=torch.bfloat16, enabled=is_half)


def layer_dtype() -> torch.dtype:
    """Return the numbers that layers multiply here, for what is made to be their input."""
    if torch.is_autocast_enabled("cpu"):
        return torch.get_autocast_dtype("cpu")
    return torch.float32


def _multiplies_bfloat16() -> bool:
    """Tell whether the processor has instructions for it; without them it is slower."""
    has = getattr(torch.cpu, "_is_avx512_bf16_supported", None)
    return bool(has and has())
