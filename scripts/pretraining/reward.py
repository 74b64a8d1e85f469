"""Pretraining: a reward network's layers below the output learn to tell which aliens are left.

A dozen ranked games say little about which screens mean the same, and a network that learns both
this and what is good from them orders games of other kinds hardly better than chance. Here the
first part is learned once, for all behaviours, from varied play and from games that clear the
lowest rows, which nobody ranks; `trainer.reward.pretraining` says what a reward makes of it.

    python -m scripts.pretraining.reward

makes the weights that ship with Tril anew; it takes eleven minutes on two cores.
"""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path

import numpy as np
import torch
from torch import Tensor
from torch.nn import functional as F

from scripts.pretraining.low_rows import play_low_rows
from scripts.pretraining.memory_reading import N_GAMES, Screens, play_games, train_readings
from trainer.nn.checkpoints import save_tensors
from trainer.nn.seeding import torch_seeded
from trainer.reward.model import Order, RewardNetwork
from trainer.reward.pretraining import WEIGHTS

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
