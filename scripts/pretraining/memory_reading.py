"""Learning what screens tell: what memory holds, which aliens are left, what would happen next.

Networks are pretrained on it. What is learned here is how the game looks and works, from varied
play that nobody ranks; it is of use for all behaviours and says nothing of any.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import cache, partial
from multiprocessing import get_context

import numpy as np
import numpy.typing as npt
import torch
from torch import Tensor, nn
from torch.nn import functional as F

from scripts.pretraining.foresight import N_HITS, N_OUTCOMES, Lookahead
from trainer.nn.screens import channels_last_screens, take_screens
from tril.demonstrators.space_invaders.varied_play import play_varied
from tril.games.base import Console
from tril.games.space_invaders import SPACE_INVADERS
from tril.games.space_invaders.memory import COLUMNS, FRAMES_PER_STEP, ROWS
from tril.play.episode import Episode, EpisodeState
from tril.play.observation import Observations
from tril.recording import Verified, replay, trajectory

N_GAMES = 1200
"""Games of varied play that the networks that ship with Tril have learned from."""

KEPT_STEPS = 4
"""Every n-th step of a game is learned from."""

HELD_OUT = 8
"""Every n-th game is held out to measure the accuracy."""

RARE = 0.01
"""Bits that are 0 or 1 in less than this share of the states are left out."""

HITS_WEIGHT = 6.0
SHOTS_WEIGHT = 36.0
"""Of the losses; that of the memory counts 1. Shots hit one alien of 36 at most."""

BATCH_SIZE = 128
LEARNING_RATE = 2e-3


@dataclass(frozen=True)
class Targets:
    """Flags that a network learns to predict from screens.

    Attributes:
        name: Name in figures.
        flags: bool (N, K).
        weight: Factor on their mean loss.
    """

    name: str
    flags: npt.NDArray[np.bool_]
    weight: float = 1.0


@dataclass(frozen=True)
class Screens:
    """Screens of varied play with what the memory held.

    Attributes:
        observations: uint8 (N, 4, 84, 84).
        bits: Bits of the memory, bool (N, 1024).
        games: Game of each screen, int64 (N,), ascending.
        outcomes: Outcomes of each move, see Lookahead, bool (N, M); M is 0 without lookahead.
        standing: Remaining aliens of the full grid, row by row, bool (N, 36).
    """

    observations: Observations
    bits: npt.NDArray[np.bool_]
    games: npt.NDArray[np.int64]
    outcomes: npt.NDArray[np.bool_]
    standing: npt.NDArray[np.bool_]

    def with_games(self, other: Screens) -> Screens:
        """Return these screens with those of more games."""
        n_games = int(self.games[-1]) + 1
        return Screens(
            np.concatenate([self.observations, other.observations]),
            np.concatenate([self.bits, other.bits]),
            np.concatenate([self.games, other.games + n_games]),
            np.concatenate([self.outcomes, other.outcomes]),
            np.concatenate([self.standing, other.standing]),
        )

    def memory(self, indices: npt.NDArray[np.int64]) -> Targets:
        """Return these bits of the memory as what is predicted."""
        return Targets("bits", self.bits[:, indices])

    def hits(self) -> Targets:
        """Return whether the cannon would be hit as what is predicted."""
        return Targets("hits", self.outcomes[:, :N_HITS], HITS_WEIGHT)

    def shots(self) -> Targets:
        """Return the alien that a shot would hit, as targets."""
        return Targets("shots", self.outcomes[:, N_HITS:], SHOTS_WEIGHT)

    def aliens(self) -> Targets:
        """Return the remaining aliens, as targets."""
        return Targets("aliens", self.standing)

    def varying(self) -> npt.NDArray[np.int64]:
        """Return the indices of the bits that vary."""
        share = self.bits.mean(0)
        return np.flatnonzero((share > RARE) & (share < 1 - RARE))


Player = Callable[[np.random.Generator, Console], Verified]
"""Plays a game."""


def play_games(
    n_games: int,
    seed: int,
    n_processes: int,
    *,
    player: Player = play_varied,
    look_ahead: bool = False,
) -> Screens:
    """Play games and keep some of their states.

    Args:
        n_games: Number of games.
        seed: Seeds all draws.
        n_processes: Processes that play; affects the speed only.
        player: Plays each; a function of a module.
        look_ahead: Whether to find out what each move would lead to, which takes most of the time.
    """
    pool = ProcessPoolExecutor(n_processes, mp_context=get_context("spawn"))
    with pool:
        played = list(
            pool.map(partial(_play_game, seed, player, look_ahead), range(n_games), chunksize=8)
        )
    observations, bits, outcomes, standing = zip(*played, strict=True)
    lengths = [len(game_bits) for game_bits in bits]
    return Screens(
        np.concatenate(observations),
        np.concatenate(bits),
        np.repeat(np.arange(n_games), lengths),
        np.concatenate(outcomes),
        np.concatenate(standing),
    )


def _play_game(
    seed: int, player: Player, look_ahead: bool, number: int
) -> tuple[Observations, npt.NDArray[np.bool_], npt.NDArray[np.bool_], npt.NDArray[np.bool_]]:
    rng = np.random.default_rng([seed, number])
    console = _console()
    recording = player(rng, console).recording
    sampled_steps = slice(int(rng.integers(KEPT_STEPS)), None, KEPT_STEPS)
    memory: list[npt.NDArray[np.uint8]] = []
    standing: list[npt.NDArray[np.bool_]] = []
    states: list[EpisodeState] = []

    def look(episode: Episode) -> None:
        if episode.frame % FRAMES_PER_STEP == 0:
            memory.append(np.frombuffer(console.ram_bytes(), np.uint8))
            standing.append(_standing(episode))
            if look_ahead:
                states.append(episode.save())

    replay(recording, console, look)
    observations = trajectory(recording, console).observations[: len(memory)]
    bits = np.unpackbits(np.array(memory[sampled_steps]), axis=1).astype(np.bool_)
    outcomes = [_lookahead().outcomes(state) for state in states[sampled_steps]]
    shape = (len(bits), N_OUTCOMES if look_ahead else 0)
    outcomes_of_moves = np.array(outcomes, np.bool_).reshape(shape)
    return observations[sampled_steps], bits, outcomes_of_moves, np.array(standing[sampled_steps])


def _standing(episode: Episode) -> npt.NDArray[np.bool_]:
    """Return the remaining aliens of the full grid, bool (36,)."""
    standing = np.ones((ROWS, COLUMNS), np.bool_)
    for hit in episode.taken:
        standing[hit.row, hit.column] = False
    return standing.ravel()


@cache
def _console() -> Console:
    return SPACE_INVADERS.make_console()


@cache
def _lookahead() -> Lookahead:
    return Lookahead(SPACE_INVADERS.make_console())


def train_readings(
    read: Callable[[Tensor], Tensor],
    weights: Iterable[nn.Parameter],
    screens: Screens,
    targets: Sequence[Targets],
    n_epochs: int,
    rng: np.random.Generator,
) -> dict[str, dict[str, float]]:
    """Train a network to predict flags from screens.

    Args:
        read: Returns the logits of all targets, one after another, float32 (N, K), of screens,
            uint8 (N, 4, 84, 84) in channels-last order.
        weights: Parameters to learn.
        screens: Screens to learn from.
        targets: Targets to predict.
        n_epochs: Passes over the screens.
        rng: Source of the order of the screens.

    Returns:
        Figures of each target, by name, from games that were held out: "accuracy", the share of
        flags predicted right, "commoner", that of always predicting the commoner value, "known",
        the share of their entropy (as flags of known frequencies) that the predictions take away,
        and the number "n_flags".
    """
    inputs = channels_last_screens(screens.observations)
    flags = torch.from_numpy(np.concatenate([target.flags for target in targets], axis=1))
    sizes = [target.flags.shape[1] for target in targets]
    importance = torch.cat(
        [
            torch.full((size,), target.weight / size)
            for target, size in zip(targets, sizes, strict=True)
        ]
    )
    held_out = screens.games % HELD_OUT == 0
    learned, tested = np.flatnonzero(~held_out), np.flatnonzero(held_out)
    optimizer = torch.optim.Adam(weights)
    n_updates = n_epochs * (len(learned) // BATCH_SIZE)
    schedule = torch.optim.lr_scheduler.OneCycleLR(optimizer, LEARNING_RATE, total_steps=n_updates)
    for chosen in _batches(learned, rng, n_updates):
        losses = F.binary_cross_entropy_with_logits(
            read(take_screens(inputs, chosen)), flags[chosen].float(), reduction="none"
        )
        loss = losses.mean(0) @ importance
        optimizer.zero_grad()
        loss.backward()  # type: ignore[no-untyped-call]
        optimizer.step()
        schedule.step()
    with torch.no_grad():
        batches = torch.split(torch.from_numpy(tested), 512)
        logits = torch.cat([read(take_screens(inputs, batch)) for batch in batches])
    truth = flags[torch.from_numpy(tested)].float()
    parts = zip(targets, torch.split(logits, sizes, 1), torch.split(truth, sizes, 1), strict=True)
    return {target.name: _figures(predicted, true) for target, predicted, true in parts}


def _figures(logits: Tensor, truth: Tensor) -> dict[str, float]:
    share = truth.mean(0)
    entropy = F.binary_cross_entropy(share.expand_as(truth), truth)
    loss = F.binary_cross_entropy_with_logits(logits, truth)
    return {
        "accuracy": ((logits > 0) == (truth > 0.5)).float().mean().item(),
        "commoner": torch.maximum(share, 1 - share).mean().item(),
        "known": (1 - loss / entropy).item(),
        "n_flags": truth.shape[1],
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
