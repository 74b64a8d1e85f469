"""Memory over hours of visits: what each process holds, and how fast that grows.

    python -m benchmarks.play.soak                            # two hours
    python -m benchmarks.play.soak --minutes 30 --rate 20     # as many visits as in ten hours
    python -m benchmarks.play.soak --minutes 10 --trace       # and which lines allocate

Players play one game after the other by the real protocol, on server processes behind one port,
with an inference process. Beside them people come by a link and leave in the middle of a game,
rewind, stop games that become recordings, watch policies, listen to changes and look at what was
recorded. Once a minute it prints the resident memory of each process. In the end it prints the
slope of each over the last two thirds, and the kinds of objects that became more. Prints a JSON
line; its exit status says whether all processes stayed flat.
"""

from __future__ import annotations

import argparse
import asyncio
import json
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Awaitable, Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import httpx2
import numpy as np
import psutil
from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import ConnectionClosed, InvalidHandshake

from benchmarks.play.support.crowd import running_crowd
from benchmarks.play.support.fleet import START_TIMEOUT_S, Fleet, running_fleet
from benchmarks.play.support.pages import HOST, arrive, client_of, owners_cookie
from server.play.wire.protocol import AckMessage
from testsupport.processes import tril_process
from testsupport.protocol import client_bytes, parse_frame
from testsupport.waiting import wait_until
from testsupport.watching import finished_run
from testsupport.workplace import make_workplace
from tril.settings import Settings
from tril.store.access.invitations import MAX_USES

FLAT_MB_PER_H = 6.0
"""Slope at which a process counts as flat: a day adds less than it takes at its start."""

WATCHERS = ("imitator.greedy", "clone.sticky")
_GONE = (OSError, EOFError, TimeoutError, ConnectionClosed, InvalidHandshake, httpx2.HTTPError)


@dataclass
class Visitors:
    """Those who come and go beside the players.

    Attributes:
        settings: Where the server is.
        run_id: A run whose policies can be watched.
        link: An invitation's path.
        counts: How many visits of each kind there were.
    """

    settings: Settings
    run_id: str
    link: str
    counts: Counter[str] = field(default_factory=Counter)
    rng: np.random.Generator = field(default_factory=lambda: np.random.default_rng(0))

    async def come_and_leave(self) -> None:
        """Come by a link, begin a game and close the browser."""
        await arrive(self.settings, self.link, f"Visitor {self.counts.total()}")

    async def play_and_stop(self) -> None:
        """Play for a second, rewind, play on, and stop: two recordings."""
        async with client_of(self.settings) as http:
            made = await http.post("/api/games", json={"behaviour_id": 1})
            if made.status_code == 503:
                self.counts["no place"] += 1
                return
            path = made.raise_for_status().json()["stream_path"]
            async with self._socket(path) as socket:
                await _say(socket, "ready")
                await _follow(socket, 1.0)
                await _say(socket, "rewind")
                await _follow(socket, 0.3)
                await _say(socket, "release")
                await _follow(socket, 1.0)
                await _say(socket, "stop")
                await _follow(socket, 20.0)

    async def watch(self) -> None:
        """Watch two games for some seconds."""
        players = "&".join(f"player={player}" for player in WATCHERS)
        start = int(self.rng.integers(32))
        path = f"/api/runs/{self.run_id}/watch?{players}&start={start}"
        async with self._socket(path) as socket:
            await socket.send(json.dumps({"type": "attention", "network": "reward"}))
            await _say(socket, "play")
            await _follow(socket, 3.0, has_lanes=True)

    async def listen(self) -> None:
        """Listen to changes for some seconds, and cause one."""
        async with (
            client_of(self.settings) as http,
            http.stream("GET", "/api/events") as events,
        ):
            notes = {"notes": f"visit {self.counts.total()}"}
            await http.patch("/api/recordings/1", json=notes)
            with suppress(TimeoutError):
                async with asyncio.timeout(3.0):
                    async for _ in events.aiter_bytes():
                        pass

    async def look(self) -> None:
        """Look at lists, and at a recording's picture, frames and clip."""
        async with client_of(self.settings) as http:
            shown = (await http.get("/api/behaviours/1/recordings")).raise_for_status().json()
            listed = (
                shown
                if isinstance(shown, list)
                else next(value for value in shown.values() if isinstance(value, list))
            )
            number = listed[int(self.rng.integers(len(listed)))]["id"]
            for path in (
                "/api/health",
                "/",
                "/api/behaviours/1/ranking",
                f"/api/recordings/{number}",
                f"/api/recordings/{number}/strip.webp",
                f"/api/recordings/{number}/frames",
                "/api/system",
            ):
                await http.get(path)

    def _socket(self, path: str) -> connect:
        cookie = owners_cookie(self.settings.data, self.settings.port)
        return connect(
            f"ws://{HOST}:{self.settings.port}{path}",
            additional_headers={"Cookie": cookie},
            compression=None,
        )

    async def repeat(self, visit: Callable[[], Awaitable[None]], every_s: float) -> None:
        """Make a visit again and again, whether or not the last one is over."""
        name = visit.__name__
        under_way: set[asyncio.Task[None]] = set()

        async def once() -> None:
            try:
                await visit()
            except _GONE as error:
                self.counts[f"{name}: {type(error).__name__}"] += 1
            else:
                self.counts[name] += 1

        due = time.monotonic()
        while True:
            task = asyncio.create_task(once())
            under_way.add(task)
            task.add_done_callback(under_way.discard)
            due += every_s
            await asyncio.sleep(max(0.0, due - time.monotonic()))


PER_MINUTE = {
    Visitors.come_and_leave: 2.0,
    Visitors.play_and_stop: 4.0,
    Visitors.watch: 2.0,
    Visitors.listen: 4.0,
    Visitors.look: 4.0,
}
"""Visits in a minute at rate 1, what a class with a few visitors makes."""


async def _say(socket: ClientConnection, command: str) -> None:
    await socket.send(json.dumps({"type": command}))


async def _follow(socket: ClientConnection, seconds: float, has_lanes: bool = False) -> None:
    """Acknowledge what comes for some time, or until the socket closes."""
    with suppress(TimeoutError, ConnectionClosed):
        async with asyncio.timeout(seconds):
            async for data in socket:
                if isinstance(data, bytes):
                    lane, frame = (data[:1], data[1:]) if has_lanes else (b"", data)
                    sequence = parse_frame(frame).sequence
                    await socket.send(lane + client_bytes(AckMessage(sequence)))


@dataclass(frozen=True)
class Sample:
    """Memory at a moment.

    Attributes:
        at_s: Seconds since the visits began.
        rss_mb: Resident memory by process.
        servers: What each server holds, see ``memory_use``.
    """

    at_s: float
    rss_mb: dict[str, float]
    servers: list[dict[str, Any]]


def take_sample(fleet: Fleet, others: dict[str, psutil.Process], began_s: float) -> Sample:
    """Measure all processes."""
    rss_mb = {}
    for number, process in enumerate(fleet.processes):
        rss_mb[f"server {number}"] = process.memory_info().rss / 1e6
        children = [child for child in process.children() if child.is_running()]
        rss_mb[f"replays {number}"] = sum(_rss(child) for child in children) / 1e6
    for name, process in others.items():
        rss_mb[name] = process.memory_info().rss / 1e6
    return Sample(time.monotonic() - began_s, rss_mb, fleet.memory())


def _rss(process: psutil.Process) -> int:
    # A process that makes a clip or an archive may end meanwhile; those are no servers.
    with suppress(psutil.NoSuchProcess):
        if "server.play.replays" in process.cmdline():
            rss: int = process.memory_info().rss
            return rss
    return 0


def slope(samples: Sequence[Sample], figures: Sequence[float]) -> float:
    """Return by how much a figure of each sample grows in an hour, over the last two thirds."""
    first = len(samples) // 3
    if len(samples) - first < 3:
        return 0.0
    hours = np.array([sample.at_s for sample in samples[first:]]) / 3600
    return float(np.polyfit(hours, figures[first:], 1)[0])


def growth(samples: list[Sample], server: int, name: str) -> dict[str, tuple[int, int]]:
    """Return what became more over the last two thirds: before and after, most first."""
    first, last = (
        sample.servers[server][name] for sample in (samples[len(samples) // 3], samples[-1])
    )
    more = {kind: (first.get(kind, 0), count) for kind, count in last.items()}
    grown = sorted(more, key=lambda kind: more[kind][0] - more[kind][1])
    return {kind: more[kind] for kind in grown[:12] if more[kind][1] > more[kind][0]}


async def visit(
    visitors: Visitors, rate: float, minutes: float, sample: Callable[[], None]
) -> None:
    """Let visitors come and go, and take a sample each minute."""
    visits = [
        asyncio.create_task(
            visitors.repeat(kind.__get__(visitors), 60.0 / (per_minute * rate)), name=kind.__name__
        )
        for kind, per_minute in PER_MINUTE.items()
    ]
    began_s = time.monotonic()
    try:
        for minute in range(int(minutes) + 1):
            await asyncio.sleep(max(0.0, began_s + 60.0 * minute - time.monotonic()))
            await asyncio.to_thread(sample)
            for task in visits:
                if task.done():
                    task.result()
    finally:
        for task in visits:
            task.cancel()
        await asyncio.gather(*visits, return_exceptions=True)


async def _invite(settings: Settings) -> str:
    async with client_of(settings) as http:
        wish: dict[str, Any] = {"name": "Visitors", "role": "participant", "behaviour_id": 1}
        wish["max_uses"] = MAX_USES
        path: str = (
            (await http.post("/api/invitations", json=wish)).raise_for_status().json()["path"]
        )
    return path


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--minutes", type=float, default=120.0)
    parser.add_argument("--rate", type=float, default=1.0, help="visits, as a multiple")
    parser.add_argument("--players", type=int, default=8)
    parser.add_argument("--servers", type=int, default=1, help="server processes")
    parser.add_argument("--games", type=int, default=64, help="most games in a process")
    parser.add_argument("--trace", action="store_true", help="say which lines allocate")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="tril-soak-") as folder:
        workplace = make_workplace(Path(folder) / "data")
        run_id = finished_run(workplace)
        workplace.database.close()
        data = workplace.settings.data
        with (
            running_fleet(
                data, arguments.servers, arguments.games, trace_memory=arguments.trace
            ) as fleet,
            tril_process(fleet.settings, "inference") as inference,
            running_crowd(fleet.settings, arguments.players, 1) as crowd,
        ):
            # PyTorch takes long to load on a machine that does much else.
            wait_until(fleet.settings.inference_socket.exists, 5 * START_TIMEOUT_S)
            crowd.counts()  # answered once the players have arrived
            link = asyncio.run(_invite(fleet.settings))
            visitors = Visitors(fleet.settings, run_id, link)
            others = {"inference": psutil.Process(inference.process.pid)}
            samples: list[Sample] = []
            began_s = time.monotonic()

            def sample() -> None:
                samples.append(take_sample(fleet, others, began_s))
                print_sample(samples[-1])

            asyncio.run(visit(visitors, arguments.rate, arguments.minutes, sample))
            played = crowd.counts()
    report(samples, visitors.counts, played.games, vars(arguments))


def print_sample(sample: Sample) -> None:
    """Print a line of the table."""
    rss = "  ".join(f"{name} {mb:6.1f}" for name, mb in sample.rss_mb.items())
    held = "; ".join(
        f"{one['blocks']:8} blocks {one['tasks']:4} tasks {one['threads']:3} threads "
        f"heap {one.get('heap_used_bytes', 0) / 1e6:6.1f} MB used, "
        f"{one.get('heap_free_bytes', 0) / 1e6:5.1f} free"
        for one in sample.servers
    )
    print(f"{sample.at_s / 60:5.0f} min  MB: {rss}  | {held}", flush=True)


def report(
    samples: list[Sample], visits: Counter[str], n_games: int, arguments: dict[str, Any]
) -> None:
    """Print slopes and what grew; exit with 1 unless all is flat."""
    slopes = {
        name: round(slope(samples, [sample.rss_mb.get(name, 0.0) for sample in samples]), 1)
        for name in samples[-1].rss_mb
    }
    print(f"\n{n_games} games of players; visits: {dict(visits)}")
    for name, mb_per_h in slopes.items():
        print(f"{name:12} {mb_per_h:+8.1f} MB/h")
    blocks = []
    for number in range(len(samples[-1].servers)):
        held = [float(sample.servers[number]["blocks"]) for sample in samples]
        per_h = slope(samples, held)
        blocks.append(round(per_h))
        print(f"server {number}: {per_h:+.0f} blocks/h")
        for name in ("objects", "lines"):
            for kind, (before, after) in growth(samples, number, name).items():
                print(f"    {before:10} -> {after:10}  {kind}")
    print(
        json.dumps(
            {
                "benchmark": "soak",
                **arguments,
                "games": n_games,
                "visits": dict(visits),
                "mb_per_h": slopes,
                "blocks_per_h": blocks,
                "rss_mb": [sample.rss_mb for sample in samples],
            }
        )
    )
    if max(slopes.values()) > FLAT_MB_PER_H:
        sys.exit(1)


if __name__ == "__main__":
    main()
