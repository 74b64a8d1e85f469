"""Time of the four attention maps of a run, against brute force.

    python -m benchmarks.learning.attention

Brute force scores every occluded observation as a whole: four screens, 82 x 82 positions of the
patch. Both are measured alternately on states of a played game, brute force on one screen at a
time; results are medians. Networks are untrained, which does not change the work. Prints a table
and a JSON line.
"""

import argparse
import json
import statistics
import time

import numpy as np
import numpy.typing as npt
import torch

from testsupport.space_invaders import Keys, action_for
from trainer.explain.attention import POSITIONS, attention_map
from trainer.explain.occlusion import PATCH
from trainer.reward.model import RewardModel, RewardNetwork
from tril.analysis.outcome import AttentionState
from tril.games.atari.starts import AtariStart
from tril.games.space_invaders import SPACE_INVADERS
from tril.recording import Recording, trajectory


def played_states(count: int) -> list[npt.NDArray[np.uint8]]:
    """Return observations spread over a game in which the player fires on the left."""
    actions = bytes([action_for(Keys.FIRE)] * 600)
    observations = trajectory(
        Recording(SPACE_INVADERS, AtariStart(5), actions), SPACE_INVADERS.make_console()
    ).observations
    return [observations[i] for i in np.linspace(1, len(observations) - 1, count).astype(int)]


def brute_force_screen(
    model: RewardModel, observation: npt.NDArray[np.uint8], screen: int
) -> npt.NDArray[np.float32]:
    """Return |R(occluded) - R| for every patch of one screen, float32 (82 * 82,)."""
    occluded = np.repeat(observation[None], POSITIONS * POSITIONS, axis=0)
    for index, target in enumerate(occluded):
        row, column = divmod(index, POSITIONS)
        target[screen, row : row + PATCH, column : column + PATCH] = 0
    plain = model.score(observation[None])
    changes: npt.NDArray[np.float32] = np.abs(model.score(occluded) - plain)
    return changes


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rounds", type=int, default=5)
    arguments = parser.parse_args()
    torch.manual_seed(0)
    model = RewardModel(RewardNetwork())
    states = played_states(len(AttentionState))
    attention_map(model, states[0])  # not counted: the first pass sets things up
    ours, brute = [], []
    for _ in range(arguments.rounds):
        begin = time.perf_counter()
        for state in states:
            attention_map(model, state)
        ours.append(time.perf_counter() - begin)
        begin = time.perf_counter()
        brute_force_screen(model, states[0], 3)
        brute.append((time.perf_counter() - begin) * 4 * len(states))
    result = {
        "four_states_s": statistics.median(ours),
        "brute_force_s": statistics.median(brute),
        "ratio": statistics.median(b / o for b, o in zip(brute, ours, strict=True)),
    }
    print(f"{'four states':<14}{result['four_states_s']:>8.2f} s")
    print(f"{'brute force':<14}{result['brute_force_s']:>8.2f} s")
    print(f"ratio: {result['ratio']:.1f}")
    print(json.dumps({"benchmark": "attention", **vars(arguments), **result}))


if __name__ == "__main__":
    main()
