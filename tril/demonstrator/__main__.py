"""Write the example of a behaviour as JSON Lines: python -m tril.demonstrator column-1 > FILE."""

import argparse
import json
import sys

import numpy as np

from tril.behaviours import READY_MADE
from tril.demonstrator.example import N_PERFECT, make_example


def main() -> None:
    """Make the demonstrations of a ready-made behaviour and print each when it is done."""
    behaviours = {behaviour.slug: behaviour for behaviour in READY_MADE}
    parser = argparse.ArgumentParser(prog="python -m tril.demonstrator", description=__doc__)
    parser.add_argument("behaviour", choices=list(behaviours))
    parser.add_argument("--perfect", type=int, default=N_PERFECT, help="how many perfect ones")
    parser.add_argument("--seed", type=int, default=0, help="training seed")
    parser.add_argument("--processes", type=int, default=1)
    chosen = parser.parse_args()
    rng = np.random.default_rng(chosen.seed)
    example = make_example(behaviours[chosen.behaviour], rng, chosen.perfect, chosen.processes)
    for demonstration in example:
        sys.stdout.write(json.dumps(demonstration.to_exchange()) + "\n")
        sys.stdout.flush()


if __name__ == "__main__":
    main()
