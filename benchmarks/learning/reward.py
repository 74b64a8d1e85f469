"""Time and accuracy of learning a reward from twelve ranked games of 300 steps.

    python -m benchmarks.learning.reward [--behaviour column-6] [--recipe paper]

The games are the scripted player's twelve of a behaviour, with twelve perfect ones where the recipe
learns from them. Measures the final model and the check with its folds, in seconds and in seconds
of CPU time, which depends less on other work on the machine. Prints a table and a JSON line.
"""

import argparse
import json
import time
from collections.abc import Callable
from typing import TypeVar

import numpy as np
import torch

from trainer.progress import NullProgress
from trainer.reward.check import check_ranking
from trainer.reward.preference_dataset import PerfectDemonstrations, PreferenceDataset
from trainer.reward.reward_trainer import train_reward_model
from tril.demonstrators.example import example_tasks, execute
from tril.games.space_invaders import SPACE_INVADERS
from tril.games.space_invaders.behaviours import BUILT_IN
from tril.recipes import RECIPES
from tril.recording import trajectory

Made = TypeVar("Made")


def timed(work: Callable[[], Made]) -> tuple[Made, float, float]:
    """Return the result of some work, its seconds and its CPU seconds."""
    begin, begin_cpu = time.perf_counter(), time.process_time()
    made = work()
    return made, time.perf_counter() - begin, time.process_time() - begin_cpu


def main() -> None:
    """Measure and print."""
    behaviours = {behaviour.slug: behaviour for behaviour in BUILT_IN}
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--behaviour", choices=list(behaviours), default="column-1")
    parser.add_argument("--recipe", choices=list(RECIPES), default="fast")
    arguments = parser.parse_args()
    recipe = RECIPES[arguments.recipe].reward
    tasks = example_tasks(behaviours[arguments.behaviour], np.random.default_rng(0))
    shown = list(execute(tasks))
    console = SPACE_INVADERS.make_console()
    ranked = sorted((d for d in shown if not d.perfect), key=lambda d: d.plan.number)
    trajectories = [trajectory(d.recording, console) for d in ranked]
    tiers = [[index] for index in range(len(ranked))]
    best = [d.recording for d in shown if d.perfect]
    perfect = PerfectDemonstrations([trajectory(one, console) for one in best], [None] * len(best))
    dataset = PreferenceDataset.from_demonstrations(trajectories, tiers, recipe, perfect)
    model, train_s, train_cpu_s = timed(lambda: train_reward_model(dataset, 0, NullProgress()))
    (check, _), check_s, check_cpu_s = timed(
        lambda: check_ranking(model, dataset, 0, NullProgress())
    )
    assert check.held_out_accuracy is not None
    together_s, together_cpu_s = train_s + check_s, train_cpu_s + check_cpu_s
    result = {
        "train_s": train_s,
        "train_cpu_s": train_cpu_s,
        "check_s": check_s,
        "check_cpu_s": check_cpu_s,
        "tau": check.tau,
        "pair_accuracy": check.pair_accuracy,
        "held_out_accuracy": check.held_out_accuracy,
    }
    print(f"{'':<22}{'seconds':>9}{'CPU':>11}")
    print(f"{'final model':<22}{train_s:>9.1f}{train_cpu_s:>11.1f}")
    print(f"{'check and its folds':<22}{check_s:>9.1f}{check_cpu_s:>11.1f}")
    print(f"{'together':<22}{together_s:>9.1f}{together_cpu_s:>11.1f}")
    print(
        f"tau {check.tau:.3f}, fragment pairs {check.pair_accuracy:.1%},"
        f" held-out pairs {check.held_out_accuracy:.1%}"
    )
    threads = torch.get_num_threads()
    print(json.dumps({"benchmark": "reward", "threads": threads, **vars(arguments), **result}))


if __name__ == "__main__":
    main()
