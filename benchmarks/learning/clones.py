"""Clones of 0.2: of twelve perfect games, with the small network and the wide one.

    python -m benchmarks.learning.clones [--behaviour column-2] [--training-seed 0]

The upper bound of the baseline: each clone plays from the 23 evaluation starts, greedily and with
sampled actions. Prints a table and a JSON line; all behaviours take half an hour on two cores.
"""

import argparse
import json
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from testsupport.space_invaders import evaluation_start
from trainer.policy.cloning import train_clone
from trainer.policy.evaluation import play
from trainer.policy.networks import SIZES, Policy
from trainer.progress import NullProgress
from tril.demonstrators.example import example_tasks, execute
from tril.games.behaviours import Behaviour, score
from tril.games.space_invaders import SPACE_INVADERS
from tril.games.space_invaders.behaviours import BUILT_IN
from tril.games.space_invaders.ends import DEATHS
from tril.recipes import PAPER
from tril.recording import Trajectory, trajectory
from tril.store.training.evaluations import ActionSelection

ACTION_SELECTIONS: tuple[ActionSelection, ...] = ("greedy", "sampled")
STARTS = [*PAPER.evaluation.start_numbers, *PAPER.evaluation.further_start_numbers]


def judge_clone(
    behaviour: Behaviour, shown: Sequence[Trajectory], network: str, training_seed: int
) -> dict[str, float]:
    """Train a clone and let it play; return its means over the games with each action selection."""
    recipe = replace(PAPER.cloning, network=network)  # type: ignore[arg-type]
    clone, learned = train_clone(shown, 6, recipe, training_seed, NullProgress())
    policy = Policy(clone)
    found = {"held_out_accuracy": learned.held_out_accuracy or np.nan}
    starts = [evaluation_start(number) for number in STARTS]
    for action_selection in ACTION_SELECTIONS:
        games = play(SPACE_INVADERS, policy, starts, action_selection, sampling_seed=training_seed)
        scores = [score(behaviour, tuple(h.cell for h in g.taken)) for g in games]
        found[f"{action_selection}_targets"] = float(
            np.mean([one.targets for one in scores if one])
        )
        found[f"{action_selection}_strays"] = float(np.mean([one.strays for one in scores if one]))
        found[f"{action_selection}_lost"] = float(np.mean([game.end in DEATHS for game in games]))
    return found


def main() -> None:
    """Measure and print."""
    behaviours = {behaviour.slug: behaviour for behaviour in BUILT_IN}
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--behaviour", choices=list(behaviours), action="append")
    parser.add_argument("--training-seed", type=int, default=0)
    arguments = parser.parse_args()
    console = SPACE_INVADERS.make_console()
    result = {}
    print("behaviour network   held out  targets strays  lost  sampled: targets strays  lost")
    for slug in arguments.behaviour or list(behaviours):
        rng = np.random.default_rng(arguments.training_seed)
        example = execute(example_tasks(behaviours[slug], rng))
        shown = [trajectory(one.recording, console) for one in example if one.perfect]
        for network in sorted(SIZES):
            one = judge_clone(behaviours[slug], shown, network, arguments.training_seed)
            result[f"{slug} {network}"] = one
            print(
                f"{slug:<9} {network:<8} {one['held_out_accuracy']:>9.1%}"
                f" {one['greedy_targets']:>8.2f} {one['greedy_strays']:>6.2f}"
                f" {one['greedy_lost']:>5.0%} {one['sampled_targets']:>17.2f}"
                f" {one['sampled_strays']:>6.2f} {one['sampled_lost']:>5.0%}",
                flush=True,
            )
    print(json.dumps({"benchmark": "clones", **vars(arguments), "result": result}))


if __name__ == "__main__":
    main()
