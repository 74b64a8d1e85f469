"""How much sooner several workers reproduce results than one, all on this machine.

    python -m benchmarks.learning.reproduce_workers --workers 2 --steps 6144

``tril reproduce`` computes four columns with one worker, then with more, each on data of its own
and each worker with one thread. As many workers as cores is the most that can be of use. Prints
the seconds, the ratio and a JSON line.
"""

from __future__ import annotations

import argparse
import json
import tempfile
import time
from contextlib import ExitStack
from pathlib import Path

from testsupport.databases import settings_on
from testsupport.processes import tril_process
from tril.cores import core_count

BEHAVIOURS = ("column-1", "column-2", "column-3", "column-4")
AT_MOST_S = 3600.0


def seconds_with(n_workers: int, steps: int) -> float:
    """Return how long the results take, from the moment at which all workers wait for runs."""
    with tempfile.TemporaryDirectory(prefix="tril-reproduce-") as folder, ExitStack() as stack:
        settings = settings_on(Path(folder) / "data", learning_threads=1)
        with tril_process(settings, "migrate") as migration:
            assert migration.process.wait(AT_MOST_S) == 0, "".join(migration.output)
        for _ in range(n_workers):
            worker = stack.enter_context(tril_process(settings, "worker"))
            worker.wait_for("waits for runs")
        asked = [word for slug in BEHAVIOURS for word in ("-b", slug)]
        output = str(Path(folder) / "results")
        began = time.monotonic()
        with tril_process(
            settings, "reproduce", *asked, "-s", "0", "--steps", str(steps), "-o", output,
        ) as reproduce:  # fmt: skip
            assert reproduce.process.wait(AT_MOST_S) == 0, "".join(reproduce.output)
        return time.monotonic() - began


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--workers", type=int, default=core_count())
    parser.add_argument("--steps", type=int, default=6144, help="of PPO, for each result")
    arguments = parser.parse_args()
    one = seconds_with(1, arguments.steps)
    several = seconds_with(arguments.workers, arguments.steps)
    print(f"1 worker: {one:.0f} s; {arguments.workers} workers: {several:.0f} s")
    print(f"{one / several:.2f} times as fast")
    print(
        json.dumps(
            {
                "benchmark": "reproduce_workers",
                **vars(arguments),
                "one_s": round(one, 1),
                "several_s": round(several, 1),
            }
        )
    )


if __name__ == "__main__":
    main()
