"""Hurts a running Tril by faults, one after the other, and checks what it acknowledged.

    python -m benchmarks.faults --faults 200 --seed 1
    python -m benchmarks.faults --faults 200 --database postgresql --store s3 \
        --servers 2 --workers 4
    python -m benchmarks.faults --faults 20 --kinds "kill worker" "pause worker for long"

Server, inference process and workers are the real ones; clients import, rank, play, and train
small runs meanwhile. As root there are more kinds of fault: data folders have a file system of
their own that is filled, and with PostgreSQL database, store, servers and workers have hosts of
their own, in network namespaces, and clocks that can be wrong.
Prints a table and a JSON line; its exit status says whether every rule of
``testsupport/faults/rules.py`` held.
"""

from __future__ import annotations

import argparse
import json
import signal
import sys
from dataclasses import asdict

import numpy as np

from testsupport.faults.campaign import campaign_folder, run_campaign
from testsupport.faults.injection import KINDS
from testsupport.faults.plan import Plan, Result


def main() -> None:
    """Run a campaign and print what came of it."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--faults", type=int, default=200)
    parser.add_argument("--hours", type=float, help="begin no fault after so many hours")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--database", choices=("sqlite", "postgresql"), default="sqlite")
    parser.add_argument("--store", choices=("folder", "s3"), default="folder")
    parser.add_argument("--servers", type=int, default=1)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--runs", type=int, default=2, help="that are not over, at a time")
    parser.add_argument("--kinds", nargs="+", choices=KINDS, help="only these")
    parser.add_argument("--in-turn", action="store_true", help="take the kinds in turn")
    arguments = parser.parse_args()
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(1))  # and end what was started
    plan = Plan(
        n_faults=arguments.faults,
        seed=arguments.seed,
        database=arguments.database,
        store=arguments.store,
        n_servers=arguments.servers,
        n_workers=arguments.workers,
        runs_at_once=arguments.runs,
        kinds=tuple(arguments.kinds) if arguments.kinds else None,
        in_turn=arguments.in_turn,
        most_s=3600 * arguments.hours if arguments.hours else float("inf"),
    )
    with campaign_folder() as folder:
        print(f"Logs and histories are in {folder}.", flush=True)
        result = run_campaign(plan, folder, lambda line: print(line, flush=True))
        report(plan, result)
        if result.violations:
            sys.exit(1)  # and leave the folder


def report(plan: Plan, result: Result) -> None:
    """Print the table and the JSON line."""
    if result.impossible:
        print(f"Not possible here: {', '.join(result.impossible)}.")
    print(f"\n{'':22}{'faults':>8}{'back after p50':>16}{'at most':>9} s")
    for kind, times_s in sorted(result.recoveries_s.items()):
        print(f"{kind:22}{len(times_s):8}{np.median(times_s):16.1f}{max(times_s):9.1f}")
    figures = {
        "faults": len(result.history.faults),
        "requests": dict(result.answers),
        "runs": len(result.runs),
        "leases_that_repeated_training": len(result.lost),
        "training_lost_most_s": round(max((one.seconds for one in result.lost), default=0.0), 1),
        "games_rejoined": len(result.lost_frames),
        "frames_lost_most": max(result.lost_frames, default=0),
        "violations": len(result.violations),
        "seconds": round(result.seconds),
    }
    for name, value in figures.items():
        print(f"{name.replace('_', ' '):<32}{value}")
    for what in result.violations:
        print(f"  {what}")
    print(json.dumps({"benchmark": "faults", "plan": asdict(plan), **figures}))


if __name__ == "__main__":
    main()
