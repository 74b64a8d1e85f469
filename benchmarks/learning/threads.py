"""Scoring by two threads that sleep or spin while they wait, with and without other work.

    python -m benchmarks.learning.threads

The reward network scores observations in processes that differ in OMP_WAIT_POLICY only, in turns;
the other work is one process that counts. Prints a table and a JSON line.
"""

import argparse
import json
import os
import statistics
import subprocess
import sys

SCORING = """
import time
import numpy as np
import torch
torch.set_num_threads(2)
from trainer.reward.model import RewardModel, RewardNetwork
model = RewardModel(RewardNetwork())
observations = np.random.default_rng(0).integers(0, 256, (2048, 4, 84, 84), dtype=np.uint8)
model.score(observations[:256])
begin = time.perf_counter()
model.score(observations)
print(len(observations) / (time.perf_counter() - begin))
"""


def rate(policy: str) -> float:
    """Return observations scored per second under a waiting policy."""
    done = subprocess.run(
        [sys.executable, "-c", SCORING],
        env={**os.environ, "OMP_WAIT_POLICY": policy},
        capture_output=True,
        text=True,
        check=True,
    )
    return float(done.stdout)


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rounds", type=int, default=3)
    arguments = parser.parse_args()
    result: dict[str, float] = {}
    for work in ("alone", "beside"):
        other = (
            subprocess.Popen([sys.executable, "-c", "while True: pass"])
            if work == "beside"
            else None
        )
        try:
            pairs = [(rate("PASSIVE"), rate("ACTIVE")) for _ in range(arguments.rounds)]
        finally:
            if other is not None:
                other.kill()
                other.wait()
        result[f"{work}_sleeping_per_s"] = statistics.median(a for a, _ in pairs)
        result[f"{work}_spinning_per_s"] = statistics.median(b for _, b in pairs)
        result[f"{work}_ratio"] = statistics.median(a / b for a, b in pairs)
    print(f"{'':<20}{'sleeping/s':>12}{'spinning/s':>12}{'ratio':>8}")
    for work, name in (("alone", "alone"), ("beside", "beside other work")):
        print(
            f"{name:<20}{result[f'{work}_sleeping_per_s']:>12.0f}"
            f"{result[f'{work}_spinning_per_s']:>12.0f}{result[f'{work}_ratio']:>8.2f}"
        )
    print(json.dumps({"benchmark": "threads", **vars(arguments), **result}))


if __name__ == "__main__":
    main()
