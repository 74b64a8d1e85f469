"""Time and accuracy of learning a reward from twelve games of 300 steps.

    python -m benchmarks.reward [--recipe paper]

The games are the ranked ones of tests/data. The time of the final model and of the check with its
folds are given, in seconds and in seconds of processor time, the latter because other work on the
machine changes it less. Prints a table and a JSON line.
"""

import argparse
import json
import time
from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

import torch

from trainer.progress import Unobserved
from trainer.reward.check import check_ranking
from trainer.reward.training import train_reward
from tril.exchange import from_exchange
from tril.game.console import Console
from tril.recipes import RECIPES
from tril.recording import trajectory

DATA = Path(__file__).parents[1] / "tests" / "data"
Made = TypeVar("Made")


def timed(work: Callable[[], Made]) -> tuple[Made, float, float]:
    """Do some work; return what it made, its seconds and its processor seconds."""
    begin, begin_cpu = time.perf_counter(), time.process_time()
    made = work()
    return made, time.perf_counter() - begin, time.process_time() - begin_cpu


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--behaviour", choices=["column-1", "column-2"], default="column-1")
    parser.add_argument("--recipe", choices=list(RECIPES), default="fast")
    arguments = parser.parse_args()
    recipe = RECIPES[arguments.recipe].reward
    lines = [json.loads(line) for line in (DATA / f"{arguments.behaviour}.jsonl").open()]
    shown = [one for one in map(from_exchange, lines) if one.tier is not None]
    console = Console()
    trajectories = [trajectory(one.recording, console) for one in shown]
    tiers = [[index] for index in range(len(shown))]
    model, train_s, train_cpu_s = timed(
        lambda: train_reward(trajectories, tiers, recipe, 1, Unobserved())
    )
    check, check_s, check_cpu_s = timed(
        lambda: check_ranking(model, trajectories, tiers, recipe, 1, Unobserved())
    )
    assert check.held_out_accuracy is not None
    result = {
        "train_s": train_s,
        "train_cpu_s": train_cpu_s,
        "check_s": check_s,
        "check_cpu_s": check_cpu_s,
        "tau": check.tau,
        "pair_accuracy": check.pair_accuracy,
        "held_out_accuracy": check.held_out_accuracy,
    }
    print(f"{'':<22}{'seconds':>9}{'processor':>11}")
    print(f"{'final model':<22}{train_s:>9.1f}{train_cpu_s:>11.1f}")
    print(f"{'check and its folds':<22}{check_s:>9.1f}{check_cpu_s:>11.1f}")
    print(f"{'together':<22}{train_s + check_s:>9.1f}{train_cpu_s + check_cpu_s:>11.1f}")
    print(
        f"tau {check.tau:.3f}, snippet pairs {check.pair_accuracy:.1%},"
        f" left-out pairs {check.held_out_accuracy:.1%}"
    )
    threads = torch.get_num_threads()
    print(json.dumps({"benchmark": "reward", "threads": threads, **vars(arguments), **result}))


if __name__ == "__main__":
    main()
