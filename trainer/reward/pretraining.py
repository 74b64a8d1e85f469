"""The pretrained reward network: its layers below the output tell which aliens are left.

A behaviour's reward is linear in the probabilities that each alien of the full grid is left, and
that the first two, three, ... six aliens of each row are all gone (`swept_to`). Rewards are
computed from screens alone. `scripts.pretraining.reward` made the weights.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np
import torch
from torch import Tensor, nn

from trainer.nn.checkpoints import load_tensors
from trainer.nn.devices import CPU, forward_batch
from trainer.nn.screens import channels_last_screens
from trainer.nn.seeding import torch_seeded
from trainer.reward.model import Order, RewardNetwork, network_of
from tril.play.observation import Observations

WEIGHTS = Path(__file__).with_name("pretrained.safetensors")


def pretrained_network(rng: np.random.Generator) -> RewardNetwork:
    """Return the pretrained network with a new output, which alone is left to learn.

    Args:
        rng: Source of the output's first weights.
    """
    tensors, metadata = load_tensors(WEIGHTS)
    weights = {name: tensor.float() for name, tensor in tensors.items()}
    network = network_of(weights, Order(metadata["order"]))
    with torch_seeded(rng):
        network.output = nn.Linear(network.output.in_features, 1)
    for name, weight in network.named_parameters():
        weight.requires_grad_(name.startswith("output"))
    return network


def read_features(observations: Observations) -> Tensor:
    """Return the inputs of every pretrained network's R: only their outputs differ.

    Args:
        observations: uint8 (N, 4, 84, 84).

    Returns:
        float32 (N, 66), the probability that each alien is left, row by row, and how far the rows
        have been swept.
    """
    network = _shipped_network()
    batches = torch.split(channels_last_screens(observations), forward_batch(CPU))
    with torch.no_grad():
        return torch.cat([network.read(batch) for batch in batches])


@cache
def _shipped_network() -> RewardNetwork:
    return pretrained_network(np.random.default_rng(0))
