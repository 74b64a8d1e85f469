"""Kills workers at random moments of runs and finishes the runs; prints what was lost.

python -m benchmarks.learning.worker_kills --kills 100 --steps 2000
"""

from __future__ import annotations

import argparse
import json
import tempfile
from collections import Counter
from pathlib import Path

import numpy as np

from testsupport.worker_kills import finish, flaws, kill_and_finish
from testsupport.worker_zygote import Zygote
from testsupport.workplace import TINY, make_workplace
from tril.jobs import Jobs
from tril.stages import Stage


def main() -> None:
    """Kill, finish, compare with a run that nothing happened to, and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--kills", type=int, default=100)
    parser.add_argument("--steps", type=int, default=256, help="PPO steps of each run")
    parser.add_argument("--life", type=float, default=0.6, help="longest life, in whole runs")
    parser.add_argument("--seed", type=int, default=0, help="of the moments of the kills")
    arguments = parser.parse_args()
    zygote = Zygote()
    with tempfile.TemporaryDirectory(prefix="tril-kills-") as folder:
        workplace = make_workplace(Path(folder))
        jobs = Jobs(workplace.database, workplace.settings)
        untouched = workplace.make_run(TINY, arguments.steps)
        jobs.enqueue(untouched)
        run_s = finish(workplace, zygote, [untouched])
        outcome = kill_and_finish(
            workplace,
            jobs,
            zygote,
            arguments.kills,
            arguments.life * run_s,
            np.random.default_rng(arguments.seed),
            steps=arguments.steps,
        )
        found = {run_id: flaws(workplace, run_id, untouched) for run_id in outcome.runs}
        jobs.close()
        workplace.database.close()
    zygote.close()
    killed_in = Counter(outcome.killed_in)
    print(f"{'stage':<16}{'kills':>8}")
    for stage in Stage:
        if killed_in[stage]:
            print(f"{stage:<16}{killed_in[stage]:>8}")
    whole = sum(not wrong for wrong in found.values())
    print(f"{whole} of {len(found)} runs finished and whole, {outcome.seconds:.0f} s in all")
    for wrong in found.values():
        for flaw in wrong:
            print(f"  {flaw}")
    print(
        json.dumps(
            {
                "benchmark": "kills",
                **vars(arguments),
                "runs": len(found),
                "whole": whole,
                "untouched_run_s": round(run_s, 1),
                "seconds": round(outcome.seconds, 1),
                "killed_in": dict(killed_in),
            }
        )
    )


if __name__ == "__main__":
    main()
