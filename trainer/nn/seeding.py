"""PyTorch's own generator, held to an explicit one where something draws from it."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

import numpy as np
import torch

Made = TypeVar("Made")


def torch_generator_from(rng: np.random.Generator, make: Callable[[], Made]) -> Made:
    """Call ``make`` while PyTorch's generator follows ``rng``, and leave it as it was after."""
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(int(rng.integers(2**63)))
        return make()
