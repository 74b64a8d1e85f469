"""Perturbed copies of perfect demonstrations: examples of worse, close to the very best.

A ranking of a dozen games says little about aliens that nobody shot: the network takes them for
targets. A perfect game that is perturbed for some steps and then goes on as recorded, now out of
place, hits such aliens, and is worse than it was. A ranking does not separate hits from the
positions of the player either: a perfect game that goes on without the fire key visits the same
positions and hits nothing.

That a policy gets worse the more noise it is perturbed by is the idea of D-REX (Brown et al. 2020,
"Better-than-Demonstrator Imitation Learning via Automatically-Ranked Demonstrations"); here the
demonstration itself is perturbed, from the emulator's saved states.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import reduce
from operator import or_

import numpy as np
import numpy.typing as npt

from tril.game.agent import AgentGame, AgentGameState
from tril.game.console import Console
from tril.game.controls import Keys, action_for, keys_for
from tril.game.space_invaders import FRAMES_PER_STEP, Action
from tril.recording import Recording

MIN_STEPS = 20
"""Of a copy; what is lost sooner shows only that it was lost."""

MAX_STEPS = 120
"""Of a copy: a fragment has at most 100 steps."""

_NO_KEY = Keys(0)

_MISSING_SHARE = 0.5
"""Probability that a copy goes on without one of the keys, instead of with bursts."""

_MISSING_KEYS = {Keys.FIRE: 2, Keys.LEFT: 1, Keys.RIGHT: 1}
"""Weight of each as the missing one, among those that are pressed in the rest of the game."""

_BURST_STEPS = (2, 15)
_BURST_SHARE = 0.02
"""Probability per step of a further burst."""

_BURST_ACTIONS = {
    Action.NOOP: 0.05,
    Action.FIRE: 0.05,
    Action.RIGHT: 0.25,
    Action.LEFT: 0.25,
    Action.RIGHTFIRE: 0.2,
    Action.LEFTFIRE: 0.2,
}
"""Probability of each action held in a burst: mostly moves, so that the game goes on out of place
and shoots down the column beside the right one."""


@dataclass(frozen=True)
class PerturbedDemonstration:
    """A copy of a game from its first perturbed step on.

    Attributes:
        original: Index of the original game.
        first_step: Step of the original at which the perturbation begins.
        observations: uint8 (N + 1, 4, 84, 84): before that step and after each of N that follow.
    """

    original: int
    first_step: int
    observations: npt.NDArray[np.uint8]


def perturb_demonstrations(
    recordings: Sequence[Recording],
    copies: int,
    rng: np.random.Generator,
    on_step: Callable[[], None],
) -> list[PerturbedDemonstration]:
    """Play perturbed copies of games, each from a sampled step before the last shot on.

    A copy that is perturbed later misses nothing and may be as good as its original.

    Args:
        recordings: The games, none of which goes on after its end.
        copies: Copies of each; those that are lost within MIN_STEPS are dropped.
        rng: Source of randomness.
        on_step: Called after every step played; what it raises ends the work.

    Returns:
        The copies, game by game.
    """
    original_game, perturbed_game = AgentGame(Console()), AgentGame(Console())
    found = []
    for original, recording in enumerate(recordings):
        last = min(
            len(recording.actions) // FRAMES_PER_STEP - MIN_STEPS, _last_shot_step(recording)
        )
        if last < 1:
            continue
        steps = sorted(rng.integers(0, last, size=copies).tolist())
        for step, state in _states(original_game, recording, steps, on_step):
            observations = _perturb(perturbed_game, recording, step, state, rng, on_step)
            if len(observations) > MIN_STEPS:
                found.append(PerturbedDemonstration(original, step, observations))
    return found


def _last_shot_step(recording: Recording) -> int:
    """Return the last step in which the fire key is held, -1 if there is none."""
    fire = [action for action in Action if keys_for(action) & Keys.FIRE]
    return max(recording.actions.rfind(action) for action in fire) // FRAMES_PER_STEP


def _states(
    game: AgentGame, recording: Recording, steps: Sequence[int], on_step: Callable[[], None]
) -> list[tuple[int, AgentGameState]]:
    """Return the states of a recorded game before some steps, in ascending order."""
    game.reset(recording.start)
    states = []
    for step in range(steps[-1] + 1):
        states += [(step, game.save())] * steps.count(step)
        _play(game, recording, step)
        on_step()
        if game.end is not None:
            break
    return states


def _perturb(
    game: AgentGame,
    recording: Recording,
    first_step: int,
    state: AgentGameState,
    rng: np.random.Generator,
    on_step: Callable[[], None],
) -> npt.NDArray[np.uint8]:
    """Return the observations of playing on without a key, or with bursts of one held action."""
    game.restore(state)
    observations = [game.observation]
    n_steps = len(recording.actions) // FRAMES_PER_STEP
    steps = range(first_step, min(n_steps, first_step + MAX_STEPS))
    missing = _draw_missing(recording, steps, rng)
    bursts = {} if missing else _draw_bursts(steps, rng)
    for step in steps:
        if game.end is not None:
            break
        if step in bursts:
            game.step(bursts[step])
        else:
            _play(game, recording, step, missing)
        observations.append(game.observation)
        on_step()
    return np.stack(observations)


def _draw_missing(recording: Recording, steps: range, rng: np.random.Generator) -> Keys:
    """Return the key to leave out in these steps; none if the copy is to have bursts instead."""
    rest = recording.actions[steps.start * FRAMES_PER_STEP : steps.stop * FRAMES_PER_STEP]
    pressed = reduce(or_, map(keys_for, set(rest)), _NO_KEY)
    keys = [key for key, weight in _MISSING_KEYS.items() if key & pressed for _ in range(weight)]
    if not keys or rng.random() >= _MISSING_SHARE:
        return _NO_KEY
    return keys[int(rng.integers(len(keys)))]


def _draw_bursts(steps: range, rng: np.random.Generator) -> dict[int, Action]:
    """Return the action held in each step of a burst; the first step begins one."""
    actions, weights = list(_BURST_ACTIONS), list(_BURST_ACTIONS.values())
    held: dict[int, Action] = {}
    for step in steps:
        if step in held or (step != steps.start and rng.random() >= _BURST_SHARE):
            continue
        action = actions[int(rng.choice(len(actions), p=weights))]
        length = int(rng.integers(*_BURST_STEPS, endpoint=True))
        held.update(dict.fromkeys(range(step, step + length), action))
    return held


def _play(game: AgentGame, recording: Recording, step: int, missing: Keys = _NO_KEY) -> None:
    """Play a step frame by frame as recorded: a person may change keys within it."""
    begin = step * FRAMES_PER_STEP
    for action in recording.actions[begin : begin + FRAMES_PER_STEP]:
        if game.end is not None:
            return
        game.advance(action_for(keys_for(action) & ~missing))
