"""Pretraining: a reward network's layers below the output learn to read memory off the screen.

A dozen ranked games say little about which screens mean the same, and a network that learns both
this and what is good from them orders games of other kinds hardly better than chance. Here the
first part is learned once, for all behaviours, from varied play that nobody ranks: the layers
predict the bits of the console's memory that change seldom. Which aliens stand is among them, what
is wanted of them is not. A behaviour's reward is then linear in the predicted bits, so that a few
rankings determine it. Rewards are computed from screens alone.

    python -m trainer.reward.pretraining

makes the weights that ship with Tril anew; it takes a quarter of an hour on two cores.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import cache, partial
from multiprocessing import get_context
from pathlib import Path

import numpy as np
import numpy.typing as npt
import torch
from torch import Tensor, nn
from torch.nn import functional as F

from trainer.nn.checkpoints import load_tensors, save_tensors
from trainer.nn.screens import channels_last_screens, take_screens
from trainer.nn.seeding import torch_seeded
from trainer.reward.model import RewardNetwork, network_of
from tril.demonstrator.varied_play import play_varied
from tril.game.console import Console
from tril.game.episode import Episode
from tril.game.observation import Observations
from tril.game.space_invaders import FRAMES_PER_STEP
from tril.recording import replay, trajectory

WEIGHTS = Path(__file__).with_name("pretrained.safetensors")

N_GAMES = 1200
KEPT_STEPS = 4
"""Every n-th step of a game is learned from."""

HELD_OUT = 8
"""Every n-th game is held out to measure the accuracy."""

RARE = 0.01
"""Bits that are 0 or 1 in less than this share of the states are left out."""

FAST = 0.01
"""Bits that differ between more than this share of neighbouring kept states are left out: timers,
positions and the like, of which R would have to be independent."""

EPOCHS = 12
BATCH_SIZE = 128
LEARNING_RATE = 2e-3


@dataclass(frozen=True)
class Screens:
    """Screens of varied play with what the memory held.

    Attributes:
        observations: uint8 (N, 4, 84, 84).
        bits: Bits of the memory, bool (N, 1024).
        games: Which game each is from, int64 (N,), ascending.
    """

    observations: Observations
    bits: npt.NDArray[np.bool_]
    games: npt.NDArray[np.int64]

    def seldom_changing(self) -> npt.NDArray[np.int64]:
        """Return the indices of the bits that vary, but seldom from one state to the next."""
        share = self.bits.mean(0)
        same_game = self.games[1:] == self.games[:-1]
        changes = (self.bits[1:] != self.bits[:-1])[same_game].mean(0)
        return np.flatnonzero((share > RARE) & (share < 1 - RARE) & (changes < FAST))


def play_games(n_games: int, seed: int, n_processes: int) -> Screens:
    """Play varied games and keep some of their states."""
    pool = ProcessPoolExecutor(n_processes, mp_context=get_context("spawn"))
    with pool:
        played = list(pool.map(partial(_play_game, seed), range(n_games), chunksize=8))
    lengths = [len(bits) for _, bits in played]
    return Screens(
        np.concatenate([observations for observations, _ in played]),
        np.concatenate([bits for _, bits in played]),
        np.repeat(np.arange(n_games), lengths),
    )


def _play_game(seed: int, number: int) -> tuple[Observations, npt.NDArray[np.bool_]]:
    rng = np.random.default_rng([seed, number])
    console = _console()
    recording = play_varied(rng, console).recording
    memory: list[npt.NDArray[np.uint8]] = []

    def look(episode: Episode) -> None:
        if episode.frame % FRAMES_PER_STEP == 0:
            memory.append(console.ram.copy())

    replay(recording, console, look)
    observations = trajectory(recording, console).observations[: len(memory)]
    kept = slice(int(rng.integers(KEPT_STEPS)), None, KEPT_STEPS)
    return observations[kept], np.unpackbits(np.array(memory[kept]), axis=1).astype(np.bool_)


@cache
def _console() -> Console:
    return Console()


def pretrain(screens: Screens, seed: int) -> tuple[RewardNetwork, dict[str, float]]:
    """Train the layers below the output to predict the bits that change seldom.

    Returns:
        The network, whose output is random, and the share of bits that it predicts right in games
        that were held out, beside that of always predicting the commoner value.
    """
    rng = np.random.default_rng(seed)
    which = screens.seldom_changing()
    with torch_seeded(rng):
        network = RewardNetwork(len(which))
    inputs = channels_last_screens(screens.observations)
    bits = torch.from_numpy(screens.bits[:, which].astype(np.float32))
    held_out = screens.games % HELD_OUT == 0
    learned, tested = np.flatnonzero(~held_out), np.flatnonzero(held_out)
    weights = [one for name, one in network.named_parameters() if not name.startswith("output")]
    optimizer = torch.optim.Adam(weights)
    n_updates = EPOCHS * (len(learned) // BATCH_SIZE)
    schedule = torch.optim.lr_scheduler.OneCycleLR(optimizer, LEARNING_RATE, total_steps=n_updates)
    for chosen in _batches(learned, rng, n_updates):
        predicted = _logits(network, take_screens(inputs, chosen))
        loss = F.binary_cross_entropy_with_logits(predicted, bits[chosen])
        optimizer.zero_grad()
        loss.backward()  # type: ignore[no-untyped-call]
        optimizer.step()
        schedule.step()
    with torch.no_grad():
        parts = torch.split(torch.from_numpy(tested), 512)
        logits = torch.cat([_logits(network, take_screens(inputs, part)) for part in parts])
    truth = bits[torch.from_numpy(tested)]
    share = truth.mean(0)
    return network, {
        "accuracy": ((logits > 0) == (truth > 0.5)).float().mean().item(),
        "commoner": torch.maximum(share, 1 - share).mean().item(),
        "n_bits": len(which),
        "n_screens": len(learned),
    }


def _logits(network: RewardNetwork, inputs: Tensor) -> Tensor:
    screens = inputs.to(torch.float32, memory_format=torch.channels_last)
    second = network.layers[1](F.leaky_relu(network.first(screens)))
    assert network.memory is not None
    return network.memory(network.hidden_values(second))  # type: ignore[no-any-return]


def _batches(
    indices: npt.NDArray[np.int64], rng: np.random.Generator, count: int
) -> Iterator[Tensor]:
    per_epoch = len(indices) // BATCH_SIZE
    for update in range(count):
        place = update % per_epoch
        if place == 0:
            order = torch.from_numpy(rng.permutation(indices))
        yield order[place * BATCH_SIZE : (place + 1) * BATCH_SIZE]


def pretrained_network(rng: np.random.Generator) -> RewardNetwork:
    """Return the pretrained network with a new output, which alone is left to learn.

    Args:
        rng: Source of the output's first weights.
    """
    tensors, _ = load_tensors(WEIGHTS)
    network = network_of({name: one.float() for name, one in tensors.items()})
    with torch_seeded(rng):
        network.output = nn.Linear(network.output.in_features, 1)
    for name, weight in network.named_parameters():
        weight.requires_grad_(name.startswith("output"))
    return network


def main() -> None:
    """Make the weights anew."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--games", type=int, default=N_GAMES)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("-o", "--output", type=Path, default=WEIGHTS)
    arguments = parser.parse_args()
    screens = play_games(arguments.games, arguments.seed, arguments.processes)
    network, figures = pretrain(screens, arguments.seed)
    halves = {name: one.half() for name, one in network.state_dict().items()}
    save_tensors(arguments.output, halves, {"figures": json.dumps(figures)})
    sys.stdout.write(f"{json.dumps(figures)}\n")


if __name__ == "__main__":
    main()
