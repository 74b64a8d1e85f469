"""Reading the console's memory off the screen, which networks are pretrained to do.

What is learned here is how the game looks, from varied play that nobody ranks; it is of use for all
behaviours and says nothing of any.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import cache, partial
from multiprocessing import get_context

import numpy as np
import numpy.typing as npt
import torch
from torch import Tensor, nn
from torch.nn import functional as F

from trainer.nn.screens import channels_last_screens, take_screens
from tril.demonstrator.varied_play import play_varied
from tril.game.console import Console
from tril.game.episode import Episode
from tril.game.observation import Observations
from tril.game.space_invaders import FRAMES_PER_STEP
from tril.recording import replay, trajectory

N_GAMES = 1200
"""Games of varied play that the networks that ship with Tril have learned from."""

KEPT_STEPS = 4
"""Every n-th step of a game is learned from."""

HELD_OUT = 8
"""Every n-th game is held out to measure the accuracy."""

RARE = 0.01
"""Bits that are 0 or 1 in less than this share of the states are left out."""

FAST = 0.01
"""Bits that differ between more than this share of neighbouring kept states change often: timers,
positions and the like."""

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

    def varying(self) -> npt.NDArray[np.int64]:
        """Return the indices of the bits that vary."""
        share = self.bits.mean(0)
        return np.flatnonzero((share > RARE) & (share < 1 - RARE))

    def seldom_changing(self) -> npt.NDArray[np.int64]:
        """Return the indices of the bits that vary, but seldom from one state to the next."""
        same_game = self.games[1:] == self.games[:-1]
        changes = (self.bits[1:] != self.bits[:-1])[same_game].mean(0)
        varying = self.varying()
        return np.asarray(varying[changes[varying] < FAST])


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


def learn_to_read(
    read: Callable[[Tensor], Tensor],
    weights: Iterable[nn.Parameter],
    screens: Screens,
    which: npt.NDArray[np.int64],
    n_epochs: int,
    rng: np.random.Generator,
) -> dict[str, float]:
    """Train a network to predict bits of the memory from screens.

    Args:
        read: Returns the logits, float32 (N, len(which)), of screens, uint8 (N, 4, 84, 84) in
            channels-last order.
        weights: What is learned.
        screens: What it is learned from.
        which: Indices of the bits.
        n_epochs: Passes over the screens.
        rng: Source of the order of the screens.

    Returns:
        "accuracy", the share of bits predicted right in games that were held out, "commoner", that
        of always predicting the commoner value, and the numbers "n_bits" and "n_screens".
    """
    inputs = channels_last_screens(screens.observations)
    bits = torch.from_numpy(screens.bits[:, which].astype(np.float32))
    held_out = screens.games % HELD_OUT == 0
    learned, tested = np.flatnonzero(~held_out), np.flatnonzero(held_out)
    optimizer = torch.optim.Adam(weights)
    n_updates = n_epochs * (len(learned) // BATCH_SIZE)
    schedule = torch.optim.lr_scheduler.OneCycleLR(optimizer, LEARNING_RATE, total_steps=n_updates)
    for chosen in _batches(learned, rng, n_updates):
        predicted = read(take_screens(inputs, chosen))
        loss = F.binary_cross_entropy_with_logits(predicted, bits[chosen])
        optimizer.zero_grad()
        loss.backward()  # type: ignore[no-untyped-call]
        optimizer.step()
        schedule.step()
    with torch.no_grad():
        parts = torch.split(torch.from_numpy(tested), 512)
        logits = torch.cat([read(take_screens(inputs, part)) for part in parts])
    truth = bits[torch.from_numpy(tested)]
    share = truth.mean(0)
    return {
        "accuracy": ((logits > 0) == (truth > 0.5)).float().mean().item(),
        "commoner": torch.maximum(share, 1 - share).mean().item(),
        "n_bits": len(which),
        "n_screens": len(learned),
    }


def _batches(
    indices: npt.NDArray[np.int64], rng: np.random.Generator, count: int
) -> Iterator[Tensor]:
    per_epoch = len(indices) // BATCH_SIZE
    for update in range(count):
        place = update % per_epoch
        if place == 0:
            order = torch.from_numpy(rng.permutation(indices))
        yield order[place * BATCH_SIZE : (place + 1) * BATCH_SIZE]
