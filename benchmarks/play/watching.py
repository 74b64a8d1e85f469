"""Watched games side by side: how late their frames begin, and how long decisions take.

    python -m benchmarks.play.watching
    python -m benchmarks.play.watching --attention reward

Runs a server process, an inference process and one page of its own, which watches policies of the
usual size (untrained ones: they are as fast as trained ones) and acknowledges every frame at once.
Games that are over are watched again from the next start. A frame is late by the time from its
deadline to its begin, waits for decisions included; a decision takes the time from a step's last
frame to the message that announces the next action, both as the page receives them. The processor
time of both processes is given, too, since other load does not change it much. With `--attention`
the page is shown what the reward or the policies look at besides. Prints a table and a JSON line.
"""

from __future__ import annotations

import argparse
import json
import os
import tempfile
import time
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import psutil
from websockets.exceptions import ConnectionClosed

from benchmarks.play.support.fleet import START_TIMEOUT_S, running_fleet
from server.play.lateness import Lateness
from testsupport.processes import tril_process
from testsupport.waiting import wait_until
from testsupport.watching import Watcher, finished_run, watching
from testsupport.workplace import TINY, make_workplace
from tril.cores import core_count
from tril.recipes import with_values
from tril.settings import Settings

PLAYERS = ("imitator.greedy", "clone.greedy", "imitator.sampled", "clone.sticky")
SHARES = {"p50": 0.5, "p95": 0.95, "p99": 0.99}
N_STARTS = 32


@dataclass
class Seen:
    """What a page has seen.

    Attributes:
        decisions_ms: From the last frame of a step to the decision on the next.
        n_frames: Frames received.
        n_waits: How often it was told that the games wait.
        n_games: Games that were watched to their end.
        n_maps: Attention maps received.
    """

    decisions_ms: list[float] = field(default_factory=list)
    n_frames: int = 0
    n_waits: int = 0
    n_games: int = 0
    n_maps: int = 0


def watch(
    settings: Settings, run_id: str, arguments: argparse.Namespace, start: int, until_s: float
) -> Seen:
    """Watch games from a start until they are over or the time is up."""
    seen = Seen()
    players = PLAYERS[: arguments.games]
    with watching(settings, run_id, *players, start=start % N_STARTS) as page:
        page.until("hello")
        if arguments.attention:
            page.say("attention", network=arguments.attention)
        page.say("play")
        shown_at = time.monotonic()
        while time.monotonic() < until_s:
            n_before = count_frames(page)
            try:
                message = page.next()
            except ConnectionClosed:
                break
            now = time.monotonic()
            if message is None:
                shown_at = now
                seen.n_frames += count_frames(page) - n_before
            elif message["type"] == "decision" and message["lane"] == 0:
                seen.decisions_ms.append(1000 * (now - shown_at))
            elif message["type"] == "waiting":
                seen.n_waits += 1
            elif message["type"] == "attention":
                seen.n_maps += 1
            elif message["type"] == "finished":
                seen.n_games += len(players)
                break
    return seen


@dataclass(frozen=True)
class CpuTimes:
    """Processor time of the server and of the inference process, seconds."""

    server_s: float
    inference_s: float


def cpu_s(process: psutil.Process) -> float:
    """Return the processor time of a process so far."""
    times = process.cpu_times()
    return times.user + times.system


def count_frames(page: Watcher) -> int:
    """Return the number of frames that a page has received."""
    return sum(map(len, page.frames.values()))


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--games", type=int, default=len(PLAYERS), choices=range(1, 5))
    parser.add_argument("--network", default="nature", choices=("small", "nature"))
    parser.add_argument("--attention", choices=("reward", "policy"))
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument("--warm-up", type=float, default=5.0)
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="tril-watching-") as folder:
        workplace = make_workplace(Path(folder) / "data")
        recipe = with_values(TINY, {"evaluation.openings": True})
        run_id = finished_run(workplace, recipe, network=arguments.network)
        workplace.database.close()
        with (
            running_fleet(workplace.settings.data, 1, 8) as fleet,
            tril_process(fleet.settings, "inference") as inference,
        ):
            wait_until(fleet.settings.inference_socket.exists, START_TIMEOUT_S)
            watch(fleet.settings, run_id, arguments, 0, time.monotonic() + arguments.warm_up)
            process = psutil.Process(inference.process.pid)
            before, load_before = fleet.sample(), os.getloadavg()[0]
            inference_before_s = cpu_s(process)
            began = time.monotonic()
            parts: list[Seen] = []
            while time.monotonic() < began + arguments.seconds:
                until_s = began + arguments.seconds
                parts.append(watch(fleet.settings, run_id, arguments, len(parts) + 1, until_s))
            took_s = time.monotonic() - began
            after, load_after = fleet.sample(), os.getloadavg()[0]
            inference_s = cpu_s(process) - inference_before_s
    late = after.watched - before.watched
    decisions = np.concatenate([part.decisions_ms for part in parts])
    cpu = CpuTimes(after.cpu_s - before.cpu_s, inference_s)
    report(late, decisions, parts, cpu, took_s, vars(arguments))
    print(f"Load of the machine (1 min): {load_before:.1f} before, {load_after:.1f} after.")


def report(
    late: Lateness,
    decisions_ms: np.ndarray[tuple[int], np.dtype[np.float64]],
    parts: list[Seen],
    cpu: CpuTimes,
    took_s: float,
    arguments: dict[str, object],
) -> None:
    """Print what was measured."""
    found = {
        "frames": late.n_frames,
        "frames_per_s": round(late.n_frames / took_s, 1),
        "late_ms": {name: late.percentile_ms(share) for name, share in SHARES.items()},
        "decision_ms": {
            name: round(float(np.quantile(decisions_ms, share)), 1)
            for name, share in SHARES.items()
        },
        "waits": sum(part.n_waits for part in parts),
        "n_games": sum(part.n_games for part in parts),
        "maps_per_s": round(sum(part.n_maps for part in parts) / took_s, 1),
        "server_ms_per_frame": round(1000 * cpu.server_s / max(1, late.n_frames), 2),
        "inference_ms_per_step": round(1000 * cpu.inference_s / max(1, len(decisions_ms)), 1),
    }
    print(f"{arguments['games']} watched games, {core_count()} cores, {took_s:.0f} s\n")
    print(f"{'':28}{'p50':>8}{'p95':>8}{'p99':>8}")
    for title, name in (("frames late, ms", "late_ms"), ("decisions take, ms", "decision_ms")):
        row = found[name]
        assert isinstance(row, dict)
        print(f"{title:28}" + "".join(f"{row[share]:8}" for share in SHARES))
    print(f"\n{found['frames_per_s']} frames/s of 60, {found['waits']} waits shown to the person,")
    print(f"{found['server_ms_per_frame']} ms of the server's processor time for a frame of all,")
    print(f"{found['inference_ms_per_step']} ms of the inference process's for a step of all.")
    if arguments["attention"]:
        print(f"{found['maps_per_s']} attention maps/s, of all games together.")
    print(json.dumps({"benchmark": "watching", **arguments, **found}))


if __name__ == "__main__":
    main()
