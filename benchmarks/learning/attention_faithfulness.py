"""Time and faithfulness of attention maps by several methods.

    python -m benchmarks.learning.attention_faithfulness [--behaviour column-3] [--states 16]

A reward is inferred from the scripted example of a behaviour, or read from a file. On states spread
over its ranked games, each method draws a map, summed over the four screens, and the deletion and
insertion tests of Petsiuk et al. (2018, section 4.1) judge the order of its pixels, see
trainer.explain.faithfulness. Areas are in levels.

The page draws the gradient's map at once and that by 3x3 occlusion after it. Times are of one
thread: seconds, and seconds of CPU, which depend less on other work. Prints a table and JSON.
"""

import argparse
import json
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import numpy.typing as npt
import torch

from trainer.explain.attention import attention_map
from trainer.explain.faithfulness import Pixels, differences, occupied_pixels, order_of
from trainer.explain.gradient import gradient_map
from trainer.explain.patches import SIDE, STRIDE, patch_map
from trainer.progress import NullProgress
from trainer.reward.model import RewardModel
from trainer.reward.preference_dataset import PerfectDemonstrations, PreferenceDataset
from trainer.reward.reward_trainer import train_reward_model
from tril.demonstrators.example import example_tasks, execute
from tril.games.behaviours import Behaviour
from tril.games.space_invaders import SPACE_INVADERS
from tril.games.space_invaders.behaviours import BUILT_IN
from tril.games.space_invaders.memory import BACKGROUND
from tril.play.observation import Observation, Observations
from tril.recipes import RECIPES, with_values
from tril.recording import Trajectory, trajectory

Map = npt.NDArray[np.float32]
Method = Callable[[RewardModel, Observation], Map]


def by_patches(side: int, stride: int) -> Method:
    """Return the method that occludes larger patches, in all four screens at once."""
    return lambda model, observation: patch_map(model, observation, side, stride)


def integrated_gradients(model: RewardModel, observation: Observation, n: int = 8) -> Map:
    """Return |integrated gradients| from the background (Sundararajan et al. 2017)."""
    pixels = torch.from_numpy(observation.astype(np.float32))
    shares = (torch.arange(n)[:, None, None, None] + 0.5) / n
    batch = (BACKGROUND + shares * (pixels - BACKGROUND)).requires_grad_(True)
    with torch.enable_grad():
        (gradient,) = torch.autograd.grad(model.of_pixels(batch).sum(), batch)
    values: Map = (gradient.mean(0) * (pixels - BACKGROUND)).abs().sum(0).numpy()
    return values


METHODS: dict[str, Method] = {
    "occlusion, 3x3": lambda model, state: attention_map(model, state).sum(0),
    "occlusion, 4x4 every 2": by_patches(4, 2),
    "occlusion, 6x6 every 3": by_patches(6, 3),
    "occlusion, 9x9 every 3": by_patches(SIDE, STRIDE),
    "gradient x input": lambda model, state: gradient_map(model, state).sum(0),
    "integrated gradients": integrated_gradients,
    "random": lambda _, state: np.random.default_rng(int(state.sum())).random(
        state.shape[1:], np.float32
    ),
}


def area(model: RewardModel, state: Observation, order: Pixels, *, insert: bool) -> float:
    """Return the mean difference of the level while pixels are deleted or inserted in an order."""
    return float(differences(model, state, order, insert=insert).mean() / (model.one - model.zero))


def learned(
    behaviour: Behaviour, updates: int, file: Path | None
) -> tuple[RewardModel, list[Trajectory]]:
    """Return a reward model of a behaviour's scripted example, and its ranked games."""
    recipe = with_values(RECIPES["fast"], {"reward.updates": updates}).reward
    shown = list(execute(example_tasks(behaviour, np.random.default_rng(0))))
    console = SPACE_INVADERS.make_console()
    ranked = sorted((d for d in shown if not d.perfect), key=lambda d: d.plan.number)
    games = [trajectory(d.recording, console) for d in ranked]
    if file is not None:
        return RewardModel.load(file), games
    best = [d.recording for d in shown if d.perfect]
    perfect = PerfectDemonstrations([trajectory(one, console) for one in best], [None] * len(best))
    tiers = [[index] for index in range(len(games))]
    dataset = PreferenceDataset.from_demonstrations(games, tiers, recipe, perfect)
    return train_reward_model(dataset, 0, NullProgress()), games


def states_of(games: list[Trajectory], count: int) -> Observations:
    """Return states spread over the games, past the first second, where little has happened."""
    every = np.concatenate([game.observations[15:] for game in games])
    return np.asarray(every[np.linspace(0, len(every) - 1, count).astype(int)], np.uint8)


def main() -> None:
    """Measure and print."""
    behaviours = {behaviour.slug: behaviour for behaviour in BUILT_IN}
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--behaviour", choices=list(behaviours), default="column-1")
    parser.add_argument(
        "--updates",
        type=int,
        default=RECIPES["fast"].reward.updates,
        help="passes of Gibbs sampling by which the reward is inferred",
    )
    parser.add_argument("--states", type=int, default=16)
    parser.add_argument("--model", type=Path, help="a run's reward model, instead of inferring one")
    arguments = parser.parse_args()
    model, games = learned(behaviours[arguments.behaviour], arguments.updates, arguments.model)
    torch.set_num_threads(1)
    states = states_of(games, arguments.states)
    pixels = [occupied_pixels(state) for state in states]
    print(f"{'':<24}{'CPU ms':>8}{'p50 ms':>9}{'p95 ms':>9}{'deletion':>10}{'insertion':>11}")
    results = {}
    for name, draw in METHODS.items():
        draw(model, states[0])  # not counted: the first pass sets things up
        seconds, cpu, deleted, inserted = [], [], [], []
        for state, where in zip(states, pixels, strict=True):
            begin, begin_cpu = time.perf_counter(), time.process_time()
            values = draw(model, state)
            seconds.append(time.perf_counter() - begin)
            cpu.append(time.process_time() - begin_cpu)
            order = order_of(values, where)
            deleted.append(area(model, state, order, insert=False))
            inserted.append(area(model, state, order, insert=True))
        p50, p95 = np.percentile(seconds, [50, 95]) * 1e3
        found = {
            "cpu_ms": float(np.median(cpu)) * 1e3,
            "p50_ms": float(p50),
            "p95_ms": float(p95),
            "deletion": float(np.mean(deleted)),
            "insertion": float(np.mean(inserted)),
        }
        print(
            f"{name:<24}{found['cpu_ms']:>8.1f}{p50:>9.1f}{p95:>9.1f}"
            f"{found['deletion']:>10.3f}{found['insertion']:>11.3f}",
            flush=True,
        )
        results[name] = found
    print(
        json.dumps(
            {
                "benchmark": "attention_faithfulness",
                **{key: str(value) for key, value in vars(arguments).items()},
                "methods": results,
            }
        )
    )


if __name__ == "__main__":
    main()
