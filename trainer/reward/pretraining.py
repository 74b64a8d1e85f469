"""Pretraining: a reward network's layers below the output learn to tell which aliens are left.

A dozen ranked games say little about which screens mean the same, and a network that learns both
this and what is good from them orders games of other kinds hardly better than chance. Here the
first part is learned once, for all behaviours, from varied play and from games that clear the
lowest rows, which nobody ranks. A behaviour's reward is then linear in the probabilities that each
alien of the full grid is left, and that the first two, three, ... six aliens of each row are all
gone (`swept_to`). Rewards are computed from screens alone.

    python -m trainer.reward.pretraining

makes the weights that ship with Tril anew; it takes eleven minutes on two cores.
"""

from __future__ import annotations

import argparse
import json
import sys
from functools import cache
from pathlib import Path

import numpy as np
import torch
from torch import Tensor, nn
from torch.nn import functional as F

from trainer.games.space_invaders.memory_reading import N_GAMES, Screens, play_games, train_readings
from trainer.nn.checkpoints import load_tensors, save_tensors
from trainer.nn.devices import CPU, forward_batch
from trainer.nn.screens import channels_last_screens
from trainer.nn.seeding import torch_seeded
from trainer.reward.model import Order, RewardNetwork, network_of
from tril.demonstrators.space_invaders.varied_play import play_low_rows
from tril.play.observation import Observations

WEIGHTS = Path(__file__).with_name("pretrained.safetensors")

N_LOW_ROWS = 600
"""Games that clear the lowest rows. Varied play hardly ever shows the lowest row gone while others
are left, and a network that has not seen that misreads it."""

N_EPOCHS = 12


def pretrain(screens: Screens, seed: int) -> tuple[RewardNetwork, dict[str, dict[str, float]]]:
    """Train the layers below the output to predict which aliens are left.

    Returns:
        The network, whose output is random, and the figures of ``train_readings``.
    """
    rng = np.random.default_rng(seed)
    targets = [screens.aliens()]
    with torch_seeded(rng):
        network = RewardNetwork(targets[0].flags.shape[1], Order.SWEEPS)
    assert network.memory is not None
    memory = network.memory

    def read(screens: Tensor) -> Tensor:
        inputs = screens.to(torch.float32, memory_format=torch.channels_last)
        second = network.layers[1](F.leaky_relu(network.first(inputs)))
        return memory(network.hidden_values(second))  # type: ignore[no-any-return]

    weights = [
        weight for name, weight in network.named_parameters() if not name.startswith("output")
    ]
    return network, train_readings(read, weights, screens, targets, N_EPOCHS, rng)


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


def main() -> None:
    """Make the weights anew."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--games", type=int, default=N_GAMES)
    parser.add_argument("--low-rows", type=int, default=N_LOW_ROWS)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("-o", "--output", type=Path, default=WEIGHTS)
    arguments = parser.parse_args()
    seed, n_processes = arguments.seed, arguments.processes
    screens = play_games(arguments.games, seed, n_processes)
    if arguments.low_rows:
        low = play_games(arguments.low_rows, seed, n_processes, player=play_low_rows)
        screens = screens.with_games(low)
    network, figures = pretrain(screens, seed)
    halves = {name: tensor.half() for name, tensor in network.state_dict().items()}
    metadata = {"figures": json.dumps(figures), "order": network.order}
    save_tensors(arguments.output, halves, metadata)
    sys.stdout.write(f"{json.dumps(figures)}\n")


if __name__ == "__main__":
    main()
