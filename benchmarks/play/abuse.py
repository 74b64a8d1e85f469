"""Players beside attacks: lateness of their frames, answers to their requests, memory.

    python -m benchmarks.play.abuse                        # 8 players, 8 s an attack
    python -m benchmarks.play.abuse --full                 # 40 players of 60 browsers, 30 s
    python -m benchmarks.play.abuse --attacks uploads rewinds

Two server processes behind one port, players over real WebSockets, and browsers that ask once a
second over new connections, while each attack of ``support/attacks.py`` runs in turn. Players,
browsers and attackers have machines of their own in life. Here they share this one, so that as root
the servers go before whatever else wants the processor (``--niceness``), which leaves how they keep
themselves from stepping games. Prints a table and a JSON line; its exit status says whether all
bounds were kept.
"""

from __future__ import annotations

import argparse
import asyncio
import json
import os
import sys
import tempfile
import time
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import httpx2
import numpy as np

from benchmarks.play.support.attacks import ATTACKS, AttackProcess
from benchmarks.play.support.crowd import Crowd, running_crowd
from benchmarks.play.support.fleet import Fleet, running_fleet
from benchmarks.play.support.pages import arrive, client_of
from testsupport.workplace import make_workplace
from tril.settings import Settings

MOST_LATE_MS = 8.0
"""Half a frame."""
MOST_WAIT_S = 1.0
ASK_EVERY_S = 1.0
SETTLE_S = 3.0
FIRST = -20
"""Niceness of what goes before everything else."""
SPARE_GAMES = 24
"""Places for attackers' games, so that players need not share theirs."""

CLASS = 20
COME_WITHIN_S = 2.0
MOST_UNTIL_FIRST_FRAME_S = 10.0

NOBODY = "nobody attacks"


@dataclass
class Asked:
    """What browsers' requests came to.

    Attributes:
        waits_s: How long each took.
        health_s: The same of the health checks.
        failures: Answers of 500 and above, by status.
        broken: Requests without an answer.
    """

    waits_s: list[float] = field(default_factory=list)
    health_s: list[float] = field(default_factory=list)
    failures: list[int] = field(default_factory=list)
    broken: int = 0


async def browse(settings: Settings, n_browsers: int, seconds: float) -> Asked:
    """Ask as honest pages do, until the time is over."""
    asked = Asked()
    until = time.monotonic() + seconds
    rng = np.random.default_rng(0)

    async def ask(http: httpx2.AsyncClient, path: str, waits_s: list[float]) -> None:
        began = time.monotonic()
        try:
            answer = await http.get(path)
        except httpx2.HTTPError:
            asked.broken += 1
        else:
            if answer.status_code >= 500:
                asked.failures.append(answer.status_code)
        waits_s.append(time.monotonic() - began)

    async def go_on(first: float) -> None:
        await asyncio.sleep(first)
        async with client_of(settings) as http:
            while time.monotonic() < until:
                await ask(http, "/api/behaviours/1/ranking", asked.waits_s)
                await ask(http, "/api/health", asked.health_s)
                await asyncio.sleep(ASK_EVERY_S)

    await asyncio.gather(*(go_on(rng.uniform(0, ASK_EVERY_S)) for _ in range(n_browsers)))
    return asked


async def come(settings: Settings) -> list[float]:
    """Let a class come by a link; returns how long each waited for their first frame."""
    async with client_of(settings) as http:
        wish = {"name": "A class", "role": "participant", "behaviour_id": 1}
        made = (await http.post("/api/invitations", json=wish)).raise_for_status()
        link: str = made.json()["path"]
    rng = np.random.default_rng(0)

    async def one(number: int) -> float:
        await asyncio.sleep(rng.uniform(0, COME_WITHIN_S))
        return await arrive(settings, link, f"Player {number}")

    return list(await asyncio.gather(*map(one, range(CLASS))))


def measure(
    fleet: Fleet, crowd: Crowd, attack: str | None, n_browsers: int, seconds: float
) -> dict[str, Any]:
    """Measure players and browsers during an attack, or without one."""
    before, counted = fleet.sample(), crowd.counts()
    attacking = None if attack is None else AttackProcess(fleet.settings, attack, seconds)
    asked = asyncio.run(browse(fleet.settings, n_browsers, seconds))
    after, counts = fleet.sample(), crowd.counts() - counted
    came_to = {} if attacking is None else attacking.counts()
    late = after.lateness - before.lateness
    waits_s = asked.waits_s or [0.0]
    return {
        "late_p50_ms": late.percentile_ms(0.5) or 0.0,
        "late_p99_ms": late.percentile_ms(0.99) or 0.0,
        "frames": late.n_frames,
        "request_p99_s": round(float(np.quantile(waits_s, 0.99)), 3),
        "request_worst_s": round(max(waits_s), 3),
        "health_worst_s": round(max(asked.health_s or [0.0]), 3),
        "requests": len(asked.waits_s),
        "failures": len(asked.failures),
        "broken": asked.broken,
        "players_broken": counts.broken,
        "before_mb": round(before.rss_bytes / 1e6),
        "after_mb": round(after.rss_bytes / 1e6),
        "attack": came_to,
    }


def exceeded(row: dict[str, Any]) -> list[str]:
    """Return which bounds a row exceeds."""
    bounds = {
        "frames are late": row["late_p99_ms"] > MOST_LATE_MS,
        "requests wait": row["request_worst_s"] > MOST_WAIT_S,
        "requests fail": row["failures"] + row["broken"] > 0,
        "players are thrown out": row["players_broken"] > 0,
    }
    return [name for name, is_exceeded in bounds.items() if is_exceeded]


def print_row(name: str, row: dict[str, Any]) -> None:
    """Print a row of the table."""
    print(
        f"{name:24}{row['late_p50_ms']:8}{row['late_p99_ms']:8}{row['request_p99_s']:9}"
        f"{row['request_worst_s']:7}{row['health_worst_s']:8}{row['failures'] + row['broken']:7}"
        f"{row['players_broken']:6}{row['before_mb']:8}{row['after_mb']:7}  "
        + ", ".join(f"{count} {what}" for what, count in row["attack"].items()),
        flush=True,
    )


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--full", action="store_true", help="40 players, 20 browsers, 30 s")
    parser.add_argument("--players", type=int, help="honest players")
    parser.add_argument("--browsers", type=int, help="honest browsers, each a request a second")
    parser.add_argument("--seconds", type=float, help="length of an attack")
    parser.add_argument("--servers", type=int, default=2, help="server processes")
    parser.add_argument("--niceness", type=int, default=FIRST if os.geteuid() == 0 else 0)
    parser.add_argument("--attacks", nargs="+", choices=ATTACKS, default=list(ATTACKS))
    arguments = parser.parse_args()
    n_players = arguments.players or (40 if arguments.full else 8)
    n_browsers = arguments.browsers or (20 if arguments.full else 8)
    seconds = arguments.seconds or (30.0 if arguments.full else 8.0)
    rows: dict[str, dict[str, Any]] = {}
    # Honest clients come second, or their own waits would be measured; attackers are nicer by 10.
    os.setpriority(os.PRIO_PROCESS, 0, arguments.niceness // 2)
    with tempfile.TemporaryDirectory(prefix="tril-abuse-") as folder:
        workplace = make_workplace(Path(folder) / "data")
        workplace.database.close()
        n_games = n_players + SPARE_GAMES
        with (
            running_fleet(
                workplace.settings.data, arguments.servers, n_games, arguments.niceness
            ) as fleet,
            running_crowd(fleet.settings, n_players, 1) as crowd,
        ):
            who = f"{n_players} players, {n_browsers} browsers, {arguments.servers} servers"
            print(f"{who} at niceness {arguments.niceness}\n")
            print(f"{'':24}{'late p50':>8}{'p99 ms':>8}{'ask p99':>9}{'worst':>7}", end="")
            print(f"{'health':>8}{'failed':>7}{'out':>6}{'MB was':>8}{'is':>7}  the attack")
            crowd.counts()  # answered once the players have arrived
            time.sleep(SETTLE_S)
            waits_s = asyncio.run(come(fleet.settings))
            for attack in (None, *arguments.attacks):
                name = attack or NOBODY
                rows[name] = measure(fleet, crowd, attack, n_browsers, seconds)
                print_row(name, rows[name])
                time.sleep(SETTLE_S)
    print("\nask, health: seconds of the browsers' requests and of health checks, each over a new")
    print("connection; failed: 5xx or no answer; out: players' connections that broke.")
    print(
        f"{CLASS} people came by a link beside the players: first frame after "
        f"{np.median(waits_s):.1f} s (median), {max(waits_s):.1f} s (slowest)."
    )
    broken = {name: bounds for name, row in rows.items() if (bounds := exceeded(row))}
    if max(waits_s) > MOST_UNTIL_FIRST_FRAME_S:
        broken["a class arrives"] = ["first frames are late"]
    for name, bounds in broken.items():
        print(f"{name}: {', '.join(bounds)}")
    print(
        json.dumps(
            {
                "benchmark": "abuse",
                "players": n_players,
                "browsers": n_browsers,
                "servers": arguments.servers,
                "niceness": arguments.niceness,
                "seconds": seconds,
                "until_first_frame_s": [round(wait_s, 2) for wait_s in waits_s],
                "rows": rows,
            }
        )
    )
    if broken:
        sys.exit(1)


if __name__ == "__main__":
    main()
