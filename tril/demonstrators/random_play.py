"""Random play: games that show what is bad in ways in which a person's games are not.

It reads nothing off the game. An action is held for a random time, as a person holds a key, and
which actions are likely changes during a game, so that games differ more than by noise.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from tril.games.base import Console, draw_start
from tril.play.episode import Episode
from tril.recording import Recorder, Verified, verify

HOLD_STEPS = (2.0, 25.0)
"""Bounds of the mean time, in steps, for which a game's actions are held."""

PHASE_STEPS = (20, 120)
"""Bounds of the time, in steps, after which the probabilities of the actions are drawn again."""

CONCENTRATION = 0.6
"""Of the Dirichlet distribution of these probabilities: below 1, few actions are likely."""


def random_actions(rng: np.random.Generator, n_actions: int) -> Iterator[int]:
    """Yield the action of every step of a game, without an end.

    The time for which an action is held is geometric; its mean is drawn once, log-uniformly.

    Args:
        rng: Source of the draws.
        n_actions: Number of the game's actions.
    """
    mean_hold = math.exp(rng.uniform(*np.log(HOLD_STEPS)))
    while True:
        probabilities = rng.dirichlet([CONCENTRATION] * n_actions)
        n_left = int(rng.integers(*PHASE_STEPS, endpoint=True))
        while n_left > 0:
            action = int(rng.choice(n_actions, p=probabilities))
            hold = min(n_left, int(rng.geometric(1 / mean_hold)))
            yield from [action] * hold
            n_left -= hold


def play_randomly(rng: np.random.Generator, console: Console) -> Verified:
    """Play a game at random to its end and verify the recording.

    Args:
        rng: Source of the start and the actions.
        console: The console to play on.

    Raises:
        RecordingRefused: The replay differs, because the emulator is not deterministic.
    """
    game = console.game
    recorder = Recorder(Episode(console, draw_start(game.starts, rng)))
    actions = random_actions(rng, game.controls.n_actions)
    while recorder.episode.end is None:
        action = next(actions)
        for _ in range(game.clock.frames_per_step):
            if recorder.episode.end is None:
                recorder.advance(action)
    return verify(recorder.recording(), console=console)
