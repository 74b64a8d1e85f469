"""Many players at once: lateness, CPU time and bytes, compared with JPEG in JSON.

    python -m benchmarks.play.players --players 40 --seconds 30

Runs server processes behind one port, and players in their own processes over real WebSockets; each
player begins a new game as soon as one is over, so that starts, ends and verification are included.
The players alternately get Tril's stream and every frame as JPEG in base64 in JSON, as CrowdPlay
sends it. Lateness is the time from a frame's deadline to the begin of its execution, over the
frames of all games; CPU time is that of all server processes.
"""

from __future__ import annotations

import argparse
import json
import tempfile
import time
from pathlib import Path
from typing import Any

from benchmarks.play.support.crowd import running_crowd
from benchmarks.play.support.fleet import Fleet, running_fleet
from server.play.lateness import Lateness
from testsupport.workplace import make_workplace
from tril.cores import core_count

WAYS = {"stream": "XOR + zlib 1 (Tril)", "jpeg": "JPEG in base64 JSON (CrowdPlay)"}
FRAME_RATE_HZ = 60


def measure(
    fleet: Fleet, stream: str, n_players: int, n_clients: int, warm_up_s: float, seconds: float
) -> dict[str, Any]:
    """Measure a window of play after a warm-up."""
    with running_crowd(fleet.settings, n_players, n_clients, stream) as crowd:
        crowd.counts()  # answered once the players have arrived
        time.sleep(warm_up_s)
        began, before, seen_before = time.monotonic(), fleet.sample(), crowd.counts()
        time.sleep(seconds)
        after, seen = fleet.sample(), crowd.counts() - seen_before
        took_s = time.monotonic() - began
    late = after.lateness - before.lateness
    return {
        "late": late.counts,
        "cpu_s": after.cpu_s - before.cpu_s,
        "took_s": took_s,
        "frames_executed": late.n_frames,
        "frames_received": seen.frames,
        "bytes_down": seen.bytes_down,
        "bytes_up": seen.bytes_up,
        "games": seen.games,
        "refused": seen.refused,
        "broken": seen.broken,
    }


def summed(rounds: list[dict[str, Any]]) -> dict[str, float]:
    """Summarise windows."""
    late = sum((Lateness(one["late"]) for one in rounds), Lateness())
    total = {name: sum(one[name] for one in rounds) for name in rounds[0] if name != "late"}
    took_s, executed = total["took_s"], max(1, late.n_frames)
    received = max(1, total["frames_received"])
    return {
        "late_p50_ms": late.percentile_ms(0.5) or 0.0,
        "late_p99_ms": late.percentile_ms(0.99) or 0.0,
        "us_per_player_frame": round(1e6 * total["cpu_s"] / executed, 1),
        "cores": round(total["cpu_s"] / took_s, 2),
        "kb_per_player_s": round(total["bytes_down"] / received * FRAME_RATE_HZ / 1000, 1),
        "kb_up_per_player_s": round(total["bytes_up"] / received * FRAME_RATE_HZ / 1000, 2),
        "playing": round(executed / took_s / FRAME_RATE_HZ, 1),
        "left_out_percent": round(100 * (1 - min(1, received / executed)), 2),
        "games": total["games"],
        "refused": total["refused"],
        "broken": total["broken"],
    }


def main() -> None:
    """Measure and print."""
    cores = core_count()
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--players", type=int, default=40)
    parser.add_argument("--servers", type=int, default=cores, help="server processes")
    parser.add_argument("--clients", type=int, default=cores, help="processes of players")
    parser.add_argument("--rounds", type=int, default=2, help="windows of each way, in turns")
    parser.add_argument("--seconds", type=float, default=30.0, help="length of a window")
    parser.add_argument("--warm-up", type=float, default=8.0, help="before each window")
    arguments = parser.parse_args()
    rounds: dict[str, list[dict[str, Any]]] = {stream: [] for stream in WAYS}
    with tempfile.TemporaryDirectory(prefix="tril-players-") as folder:
        workplace = make_workplace(Path(folder) / "data")
        workplace.database.close()
        with running_fleet(workplace.settings.data, arguments.servers, arguments.players) as fleet:
            for _ in range(arguments.rounds):
                for stream in WAYS:
                    window = measure(
                        fleet,
                        stream,
                        arguments.players,
                        arguments.clients,
                        arguments.warm_up,
                        arguments.seconds,
                    )
                    rounds[stream].append(window)
    found = {stream: summed(windows) for stream, windows in rounds.items()}
    print(
        f"{arguments.players} players, {arguments.servers} server processes, {cores} cores, "
        f"{arguments.rounds} x {arguments.seconds:g} s each\n"
    )
    print(f"{'':32}{'late p50':>10}{'p99 ms':>8}{'us/frame':>10}", end="")
    print(f"{'cores':>7}{'playing':>9}{'kB/s':>7}{'left out':>10}")
    for stream, name in WAYS.items():
        row = found[stream]
        print(
            f"{name:32}{row['late_p50_ms']:10}{row['late_p99_ms']:8}{row['us_per_player_frame']:10}"
            f"{row['cores']:7}{row['playing']:9}{row['kb_per_player_s']:7}{row['left_out_percent']:9}%"
        )
    print("\nus/frame: CPU time of the servers per player and frame; playing: players whose")
    print("game ran, on average; kB/s: to a player at 60 Hz; left out: frames that nobody got.")
    print(json.dumps({"benchmark": "players", **vars(arguments), "cores": cores, **found}))


if __name__ == "__main__":
    main()
