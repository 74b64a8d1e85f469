r"""How well rewards learned from games like a person's order games that they have not seen.

    python -m benchmarks.learning.generalisation column-2:2 column-4:2 \
        --set reward.updates=100 --set "reward.updates=2000"

For each behaviour and seed, rewards are learned from twelve ranked games of a player who reacts
after 250 ms, 24 games of varied play and twelve best efforts: first as `fast` learns them, then
with the values of each `--set`. Prints Kendall's tau of the levels that unseen games end at with
what they are worth: of own games, which a flawless and a person-like player played for the
behaviour; of those of them without a stray; and of varied play. A reward takes some seconds.
"""

from __future__ import annotations

import argparse
import sys
from dataclasses import replace

import numpy as np
import torch

from benchmarks.learning.people import Lesson, arguments_of
from trainer.progress import NullProgress
from trainer.reward.reward_trainer import train_reward_model
from tril.recipes import FAST, RewardRecipe, with_values

N_SEEDS = 2
"""Rewards that a figure is the mean of; they differ in what is drawn at random."""


def measure(cell: str, recipes: dict[str, RewardRecipe]) -> dict[str, dict[str, float]]:
    """Return the taus of each recipe's rewards in one cell."""
    behaviour, seed = cell.rsplit(":", 1)
    lesson = Lesson(arguments_of(["-b", behaviour, "-s", seed, "--varied-games", "24"]))
    dataset = lesson.dataset()
    found = {}
    for name, recipe in recipes.items():
        taus = [
            lesson.unseen.taus(
                train_reward_model(replace(dataset, recipe=recipe), int(seed) + k, NullProgress())
            )
            for k in range(N_SEEDS)
        ]
        found[name] = {
            kind: float(np.mean([np.nan if one[kind] is None else one[kind] for one in taus]))
            for kind in taus[0]
        }
        line = " ".join(f"{kind} {tau:.3f}" for kind, tau in found[name].items())
        sys.stdout.write(f"{cell} {name}: {line}\n")
        sys.stdout.flush()
    return found


def main() -> None:
    """Learn and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument(
        "cells", nargs="*", default=["column-2:2", "column-4:2"], metavar="BEHAVIOUR:SEED"
    )
    parser.add_argument("--set", action="append", default=[], metavar="NAME=VALUE ...")
    parser.add_argument("--threads", type=int, default=1)
    arguments = parser.parse_args()
    torch.set_num_threads(arguments.threads)
    recipes = {"fast": FAST.reward}
    for values in arguments.set:
        changes = dict(one.split("=", 1) for one in values.split())
        recipes[values] = with_values(FAST, changes).reward
    cells = [measure(cell, recipes) for cell in arguments.cells]
    for name in recipes:
        means = {kind: np.mean([cell[name][kind] for cell in cells]) for kind in cells[0][name]}
        line = " ".join(f"{kind} {tau:.3f}" for kind, tau in means.items())
        sys.stdout.write(f"mean {name}: {line}\n")


if __name__ == "__main__":
    main()
