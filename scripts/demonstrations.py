"""Scripted demonstrations as JSON Lines: ``python -m scripts.demonstrations column-1``."""

import argparse
import json
import sys
from typing import Any

import numpy as np

from tril.demonstrators import N_PERFECT, Demonstration, example_tasks, execute
from tril.exchange.formats.recording_file import dump_recording
from tril.games import published


def demonstration_object(demonstration: Demonstration, tier: int | None = None) -> dict[str, Any]:
    """Return a demonstration in the exchange format.

    Args:
        demonstration: The demonstration.
        tier: Tier in the ranking, from 1; None takes the plan's number. Ignored if perfect.
    """
    return dump_recording(
        demonstration.recording,
        taken=demonstration.replay.taken,
        end=demonstration.replay.end,
        tier=None if demonstration.perfect else tier or demonstration.plan.number,
        perfect=demonstration.perfect,
        source="scripted",
        conditions=demonstration.conditions,
        notes=demonstration.notes,
    )


def main() -> None:
    """Make the demonstrations of a built-in behaviour and print each when it is done."""
    behaviours = {behaviour.slug: behaviour for behaviour in published()}
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("behaviour", choices=list(behaviours))
    parser.add_argument("--perfect", type=int, default=N_PERFECT, help="how many perfect ones")
    parser.add_argument("--seed", type=int, default=0, help="training seed")
    parser.add_argument("--processes", type=int, default=1)
    chosen = parser.parse_args()
    rng = np.random.default_rng(chosen.seed)
    tasks = example_tasks(behaviours[chosen.behaviour], rng, chosen.perfect)
    for demonstration in execute(tasks, chosen.processes):
        sys.stdout.write(json.dumps(demonstration_object(demonstration)) + "\n")
        sys.stdout.flush()


if __name__ == "__main__":
    main()
