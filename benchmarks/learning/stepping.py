"""Stepping speed of a vector of games, as a share of the emulator's own.

    python -m benchmarks.learning.stepping

Raw is what the machine's cores can emulate: as many processes as cores, each of which only calls
act four times and getScreenGrayscale twice per step, on games like the vector's. Raw and vector
are measured in turns, so that other work on the machine weighs on both, and medians over the
rounds are given. The vector's rate is that of VectorGame.step seen from its caller: with the
observations, the reading of the aliens, the ends and the new starts. Prints a table and a JSON
line.
"""

import argparse
import json
import multiprocessing as mp
import statistics
import time
from multiprocessing.connection import Connection

import ale_py
import numpy as np

from tril.cores import core_count
from tril.games.atari.catalogue import rom_path
from tril.games.space_invaders import SPACE_INVADERS
from tril.games.space_invaders import memory as game
from tril.play.vector.vector_game import TrainingStarts, VectorGame


def raw_process(connection: Connection, seed: int) -> None:
    """Step one console by random actions as fast as it goes, each time a step count comes."""
    ale_py.ALEInterface.setLoggerMode(ale_py.LoggerMode.Error)
    ale = ale_py.ALEInterface()
    ale.setFloat("repeat_action_probability", 0.0)
    ale.loadROM(rom_path(game.GAME))
    ale.reset_game()
    actions = ale.getMinimalActionSet()
    for _ in range(game.INTRO_FRAMES):
        ale.act(actions[0])
    first = ale.cloneState()
    rng = np.random.default_rng(seed)
    step = 0
    connection.send(None)
    while steps := connection.recv():
        for index in rng.integers(len(actions), size=steps).tolist():
            action = actions[index]
            ale.act(action)
            ale.act(action)
            ale.act(action)
            ale.getScreenGrayscale()
            ale.act(action)
            ale.getScreenGrayscale()
            step += 1
            # Stay in the part of the game that episodes play in.
            if step % 150 == 0:
                ale.restoreState(first)
        connection.send(None)


class Raw:
    """Processes that only emulate."""

    def __init__(self, n_processes: int) -> None:
        context = mp.get_context("spawn")
        self.connections = []
        self.processes = []
        for seed in range(n_processes):
            ours, theirs = context.Pipe()
            process = context.Process(target=raw_process, args=(theirs, seed), daemon=True)
            process.start()
            self.connections.append(ours)
            self.processes.append(process)
        for connection in self.connections:
            connection.recv()

    def rate(self, steps: int) -> float:
        """Return steps per second of all processes together."""
        begin = time.perf_counter()
        for connection in self.connections:
            connection.send(steps // len(self.connections))
        for connection in self.connections:
            connection.recv()
        return steps / (time.perf_counter() - begin)

    def close(self) -> None:
        """End the processes."""
        for connection in self.connections:
            connection.send(0)
        for process in self.processes:
            process.join()


def vector_rate(vector: VectorGame, steps: int, rng: np.random.Generator) -> float:
    """Return steps per second of all games of a vector together."""
    calls = steps // vector.n_games
    actions = rng.integers(len(game.Action), size=(calls, vector.n_games))
    begin = time.perf_counter()
    for row in actions:
        vector.step(row)
    return calls * vector.n_games / (time.perf_counter() - begin)


def measure(n_games: int, n_processes: int, rounds: int, steps: int) -> dict[str, float]:
    """Measure raw and vector in turns and return the medians."""
    raw = Raw(n_processes)
    rng = np.random.default_rng(0)
    starts = TrainingStarts(SPACE_INVADERS)
    with VectorGame(
        SPACE_INVADERS, n_games, starts, n_processes=n_processes, training_seed=0
    ) as vector:
        vector.reset()
        # Not counted: caches are cold and most starts are reached for the first time.
        raw.rate(steps)
        vector_rate(vector, steps, rng)
        pairs = [(raw.rate(steps), vector_rate(vector, steps, rng)) for _ in range(rounds)]
    raw.close()
    return {
        "raw_steps_per_s": statistics.median(one for one, _ in pairs),
        "vector_steps_per_s": statistics.median(two for _, two in pairs),
        "share": statistics.median(two / one for one, two in pairs),
        "share_lowest": min(two / one for one, two in pairs),
        "share_highest": max(two / one for one, two in pairs),
    }


def main() -> None:
    """Measure and print."""
    cores = core_count()
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--games", type=int, default=24, help="games in the vector")
    parser.add_argument("--processes", type=int, default=cores, help="of raw and of the vector")
    parser.add_argument("--rounds", type=int, default=9)
    parser.add_argument("--steps", type=int, default=4800, help="per round, raw and vector each")
    arguments = parser.parse_args()
    result = measure(arguments.games, arguments.processes, arguments.rounds, arguments.steps)
    print(f"{'':<8}{'steps/s':>10}")
    print(f"{'raw':<8}{result['raw_steps_per_s']:>10.0f}")
    print(f"{'vector':<8}{result['vector_steps_per_s']:>10.0f}")
    low, high = result["share_lowest"], result["share_highest"]
    print(f"share of raw: {result['share']:.1%} (lowest {low:.1%}, highest {high:.1%})")
    print(json.dumps({"benchmark": "stepping", **vars(arguments), **result}))


if __name__ == "__main__":
    main()
