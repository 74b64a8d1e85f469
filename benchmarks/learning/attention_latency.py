"""How long a page waits for the quick attention map of a state, beside a training.

    python -m benchmarks.learning.attention_latency

Runs a server process and an inference process at the priority that `tril up` gives them, and beside
them a process at a training's priority that learns a reward network with as many threads as there
are cores. A page asks for the gradient map of one state after the other of a recording, as it does
while a person steps through it. The time is from the request to the whole answer. `direct` is that
of the inference process alone, asked over its own socket. Prints a table and a JSON line.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext
from pathlib import Path

import httpx2
import numpy as np
import torch

from benchmarks.learning.attention import played_states
from benchmarks.play.support.fleet import START_TIMEOUT_S, running_fleet
from testsupport.live import TIMEOUT_S, cookie
from testsupport.processes import tril_process
from testsupport.waiting import wait_until
from testsupport.watching import finished_run
from testsupport.workplace import TINY, make_workplace
from trainer.nn.seeding import torch_seeded
from trainer.reward.model import RewardModel
from trainer.reward.pretraining import pretrained_network
from trainer.runtime.priority import lower_priority
from tril.cores import core_count
from tril.inference import InferenceClient, endpoint_of
from tril.settings import Settings

NETWORKS = ("reward", "imitator")


def learn_for_ever() -> None:
    """Learn a reward network on random screens, as a training's heaviest stages do."""
    lower_priority(Settings().learning_niceness)
    torch.set_num_threads(core_count())
    with torch_seeded(np.random.default_rng(0)):
        network = pretrained_network(np.random.default_rng(0))
        screens = torch.randint(0, 256, (256, 4, 84, 84), dtype=torch.uint8)
    network.requires_grad_(True)
    optimizer = torch.optim.Adam(network.parameters(), 1e-5)
    while True:
        optimizer.zero_grad()
        network(screens).square().mean().backward()
        optimizer.step()


@contextmanager
def training() -> Iterator[None]:
    """Run ``learn_for_ever`` beside the block."""
    program = "from benchmarks.learning.attention_latency import learn_for_ever; learn_for_ever()"
    process = subprocess.Popen([sys.executable, "-c", program])
    try:
        time.sleep(5.0)  # until it learns
        yield
    finally:
        process.kill()
        process.wait()


def times_ms(ask: Callable[[int], object], numbers: list[int]) -> list[float]:
    """Return how long each of several requests takes."""
    found = []
    for number in numbers:
        began = time.perf_counter()
        ask(number)
        found.append(1000 * (time.perf_counter() - began))
        # As long as a state is shown before its map is asked for.
        time.sleep(0.06)
    return found


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--requests", type=int, default=60)
    parser.add_argument("--alone", action="store_true", help="without a training beside")
    arguments = parser.parse_args()
    results = {}
    with tempfile.TemporaryDirectory(prefix="tril-attention-") as folder:
        workplace = make_workplace(Path(folder) / "data")
        model = RewardModel(pretrained_network(np.random.default_rng(0)))
        run_id = finished_run(workplace, TINY, model=model, network="small")
        recording, states = workplace.ranked[0], played_states(arguments.requests)
        workplace.database.close()
        with (
            running_fleet(workplace.settings.data, 1, 2) as fleet,
            tril_process(fleet.settings, "inference"),
            nullcontext() if arguments.alone else training(),
        ):
            wait_until(fleet.settings.inference_socket.exists, START_TIMEOUT_S)
            client = InferenceClient(endpoint_of(fleet.settings))
            http = httpx2.Client(
                base_url=f"http://127.0.0.1:{fleet.settings.port}",
                headers={"Cookie": cookie(fleet.settings)},
                timeout=TIMEOUT_S,
            )
            trace = http.get(f"/api/runs/{run_id}/reward/{recording}").raise_for_status().json()
            n_states = len(trace["levels"])
            for network in NETWORKS:

                def page(number: int, network: str = network) -> None:
                    http.get(
                        f"/api/runs/{run_id}/attention/{recording}",
                        params={
                            "step": number % n_states,
                            "method": "gradient",
                            "network": network,
                        },
                    ).raise_for_status()

                def direct(number: int, network: str = network) -> None:
                    client.attention(
                        run_id,
                        states[number],
                        network,  # type: ignore[arg-type]
                        "gradient",
                        lambda: False,
                    )

                for name, ask in (("page", page), ("direct", direct)):
                    first, *rest = times_ms(ask, list(range(arguments.requests)))
                    p50, p95 = np.percentile(rest, [50, 95])
                    results[f"{network}, {name}"] = {"first": first, "p50": p50, "p95": p95}
            http.close()
    print(f"{core_count()} cores, load (1 min) {os.getloadavg()[0]:.1f}\n")
    print(f"{'ms':<20}{'first':>9}{'p50':>9}{'p95':>9}")
    for name, found in results.items():
        print(f"{name:<20}" + "".join(f"{value:>9.1f}" for value in found.values()))
    print(json.dumps({"benchmark": "attention_latency", **vars(arguments), "ms": results}))


if __name__ == "__main__":
    main()
