"""Explicit seeding of PyTorch's global generator, for code that draws from it."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
import torch


@contextmanager
def torch_seeded(rng: np.random.Generator) -> Iterator[None]:
    """Seed PyTorch's global generator from ``rng`` within the block and restore it afterwards."""
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(int(rng.integers(2**63)))
        yield
