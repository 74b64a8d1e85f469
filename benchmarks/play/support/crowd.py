"""Players in their own processes: ``python -m benchmarks.play.support.crowd``, or Crowd.

A process prints its players' counts for each line on its standard input, and ends with it.
"""

from __future__ import annotations

import argparse
import asyncio
import json
import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import asdict
from pathlib import Path

import numpy as np

from benchmarks.play.support.pages import Counts, play_on_and_on
from tril.settings import Settings

NICENESS = 5
"""Players have machines of their own; on this one they must not starve the server."""

ARRIVE_WITHIN_S = 2.0


class Crowd:
    """Players in their own processes."""

    def __init__(self, processes: list[subprocess.Popen[str]]) -> None:
        self._processes = processes

    def counts(self) -> Counts:
        """Return the sum of all players' counts."""
        for process in self._processes:
            assert process.stdin is not None
            process.stdin.write("\n")
            process.stdin.flush()
        total = Counts()
        for process in self._processes:
            assert process.stdout is not None
            total += Counts(**json.loads(process.stdout.readline()))
        return total


@contextmanager
def running_crowd(
    settings: Settings, n_players: int, n_processes: int, stream: str = "stream"
) -> Iterator[Crowd]:
    """Run players, spread over processes, for the block."""
    processes = []
    with ExitStack() as stack:
        for number in range(n_processes):
            share = n_players // n_processes + (number < n_players % n_processes)
            arguments = {
                "--data": settings.data,
                "--port": settings.port,
                "--players": share,
                "--stream": stream,
                "--seed": number,
            }
            words = [str(word) for pair in arguments.items() for word in pair]
            process = subprocess.Popen(
                [sys.executable, "-m", "benchmarks.play.support.crowd", *words],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                text=True,
            )
            stack.callback(_end, process)
            processes.append(process)
        yield Crowd(processes)


def _end(process: subprocess.Popen[str]) -> None:
    assert process.stdin is not None
    assert process.stdout is not None
    process.stdin.close()
    try:
        process.wait(20)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()
    process.stdout.close()


async def _play(settings: Settings, n_players: int, stream: str, seed: int) -> None:
    counts = Counts()
    rng = np.random.default_rng(seed)

    async def arrive(after_s: float) -> None:
        await asyncio.sleep(after_s)
        await play_on_and_on(settings, counts, rng, stream)

    players = [
        asyncio.create_task(arrive(rng.uniform(0, ARRIVE_WITHIN_S))) for _ in range(n_players)
    ]
    asking = asyncio.create_task(_answer(counts))
    done, _ = await asyncio.wait([*players, asking], return_when=asyncio.FIRST_COMPLETED)
    for task in done:
        task.result()  # players never end by themselves: raise their error
    for player in players:
        player.cancel()
    await asyncio.gather(*players, return_exceptions=True)


async def _answer(counts: Counts) -> None:
    while await asyncio.to_thread(sys.stdin.readline):
        print(json.dumps(asdict(counts)), flush=True)


def main() -> None:
    """Play until standard input closes."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--data", type=Path, required=True)
    parser.add_argument("--port", type=int, required=True)
    parser.add_argument("--players", type=int, required=True)
    parser.add_argument("--stream", default="stream")
    parser.add_argument("--seed", type=int, default=0)
    arguments = parser.parse_args()
    os.nice(NICENESS)
    settings = Settings(data=arguments.data, port=arguments.port)
    asyncio.run(_play(settings, arguments.players, arguments.stream, arguments.seed))


if __name__ == "__main__":
    main()
