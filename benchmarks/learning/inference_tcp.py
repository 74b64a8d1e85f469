"""How much longer requests to the inference process take over TCP than over its socket.

    python -m benchmarks.learning.inference_tcp

Runs three inference processes on one data folder: on the socket, over TCP, and over TLS, both on
loopback, where they prove their key. Each request is made of all three, each of them first in
turns, so that whatever else the machine does slows all of them. `ping`, `reward` and `map` (by the
gradient) each open a connection, as the server does for a page; `act` asks for a watched game's
next action on a connection that stays open. Prints the medians, their ratios to the socket's, and a
JSON line.
"""

from __future__ import annotations

import argparse
import asyncio
import json
import os
import secrets
import socket
import tempfile
import time
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.learning.attention import played_states
from server.play.watch.policy_client import PolicyClient
from testsupport.certificates import make_certificate
from testsupport.processes import tril_process
from testsupport.watching import finished_run
from testsupport.workplace import TINY, make_workplace
from trainer.reward.model import RewardModel
from trainer.reward.pretraining import pretrained_network
from tril.cores import core_count
from tril.inference import Endpoint, InferenceClient, endpoint_of
from tril.play.observation import Observations
from tril.settings import Settings

WAYS = ("socket", "tcp", "tls")
REQUESTS = ("ping", "reward", "map", "act")


def settings_of(way: str, folder: Path) -> Settings:
    """Return the settings of an inference process that is asked this way."""
    settings = Settings(data=folder / "data")
    if way == "socket":
        return settings
    with socket.create_server(("127.0.0.1", 0)) as probe:
        address = f"{way}://127.0.0.1:{probe.getsockname()[1]}"
    certificate = make_certificate(folder)
    more: dict[str, Any] = {"tls_certificate": certificate.path, "tls_key": certificate.key}
    key = folder / "key"
    key.write_text(secrets.token_hex(32))
    return settings.model_copy(
        update={"inference_address": address, "inference_key_file": key, **more}
    )


async def measure(
    endpoints: dict[str, Endpoint], run_id: str, states: Observations
) -> dict[str, dict[str, list[float]]]:
    """Return the milliseconds that each request took each way, by request and way."""
    took: dict[str, dict[str, list[float]]] = {
        request: {way: [] for way in endpoints} for request in REQUESTS
    }
    clients = {way: InferenceClient(endpoint) for way, endpoint in endpoints.items()}
    watching = {way: PolicyClient(endpoint, run_id) for way, endpoint in endpoints.items()}
    for number in range(len(states)):
        one = states[number : number + 1]
        first = number % len(endpoints)
        in_turns = [*list(endpoints)[first:], *list(endpoints)[:first]]
        for request in REQUESTS:
            for way in in_turns:
                client = clients[way]
                began = time.perf_counter()
                if request == "ping":
                    client.ping()
                elif request == "reward":
                    client.judge(run_id, one)
                elif request == "map":
                    client.attention(run_id, one[0], "reward", "gradient", lambda: False)
                else:
                    await watching[way].act(["imitator"], one)
                took[request][way].append(1000 * (time.perf_counter() - began))
    for opened in watching.values():
        opened.close()
    return took


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--requests", type=int, default=200)
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="tril-inference-") as name:
        folder = Path(name)
        workplace = make_workplace(folder / "data")
        model = RewardModel(pretrained_network(np.random.default_rng(0)))
        run_id = finished_run(workplace, TINY, model=model, network="small")
        workplace.database.close()
        states = np.stack(list(played_states(arguments.requests + 5)))
        with ExitStack() as stack:
            endpoints = {}
            for way in WAYS:
                settings = settings_of(way, folder)
                process = stack.enter_context(tril_process(settings, "inference"))
                process.wait_for("Inference answers")
                endpoints[way] = endpoint_of(settings)
            took = asyncio.run(measure(endpoints, run_id, states))
    print(f"{core_count()} cores, load (1 min) {os.getloadavg()[0]:.1f}\n")
    print(f"{'p50, ms':<10}" + "".join(f"{way:>9}" for way in WAYS) + f"{'tcp':>10}{'tls':>8}")
    results = {}
    for request, by_way in took.items():
        # The first ones load networks and code.
        medians = {way: float(np.median(times[5:])) for way, times in by_way.items()}
        ratios = {way: medians[way] / medians["socket"] for way in WAYS[1:]}
        results[request] = {"p50": medians, "ratio": ratios}
        print(
            f"{request:<10}"
            + "".join(f"{medians[way]:>9.2f}" for way in WAYS)
            + f"{ratios['tcp']:>9.2f}x{ratios['tls']:>7.2f}x"
        )
    print(json.dumps({"benchmark": "inference_tcp", **vars(arguments), "ms": results}))


if __name__ == "__main__":
    main()
