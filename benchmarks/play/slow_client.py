"""Pages that stop reading: frames in flight, the server's memory, and the other games.

    python -m benchmarks.play.slow_client --slow 20 --players 8 --seconds 60

Players play on one server process, first alone, then beside pages that begin a game, draw some
frames and then stop reading from their connection while they still ask the game to go on. At the
end these pages read what has piled up; frames in flight are those since the last acknowledged one.
Prints a table and a JSON line.
"""

from __future__ import annotations

import argparse
import asyncio
import json
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.play.support.crowd import Crowd, running_crowd
from benchmarks.play.support.fleet import Fleet, Sample, running_fleet
from benchmarks.play.support.pages import Counts, Page, client_of, join, new_game
from server.play.lateness import Lateness
from server.play.wire.protocol import MAX_UNACKNOWLEDGED
from testsupport.workplace import make_workplace
from tril.settings import Settings

FRAMES_DRAWN = 30
GO_ON_EVERY_S = 1.0
SAMPLE_EVERY_S = 1.0
DRAIN_S = 3.0


@dataclass(frozen=True)
class Stopped:
    """A page that stopped reading.

    Attributes:
        in_flight: Frames received after the last one that it acknowledged.
        is_closed: Whether the server closed its connection for lack of pongs.
    """

    in_flight: int
    is_closed: bool


async def stop_reading(settings: Settings, seconds: float, seed: int) -> Stopped:
    """Play briefly, then stop reading for some time while asking the game to go on."""
    counts = Counts()
    drawn = asyncio.Event()

    def see(sequence: int) -> None:
        if sequence > FRAMES_DRAWN:
            page.acknowledges = False
            drawn.set()

    def make(path: str) -> Page:
        return Page(settings, path, counts, np.random.default_rng(seed), on_frame=see)

    async with client_of(settings) as http:
        path = await new_game(http, counts)
    assert path is not None
    page = await join(settings, path, make)
    await drawn.wait()
    page.transport.pause_reading()
    until = time.monotonic() + seconds
    while time.monotonic() < until and not page.transport.is_closing():
        page.say({"type": "go_on"})
        await asyncio.sleep(GO_ON_EVERY_S)
    page.transport.resume_reading()
    await asyncio.sleep(DRAIN_S)
    stopped = Stopped(counts.frames - FRAMES_DRAWN, page.over.done())
    page.transport.close()
    return stopped


async def stop_many(settings: Settings, n: int, seconds: float) -> list[Stopped]:
    """Run several pages that stop reading at the same time."""
    return await asyncio.gather(*(stop_reading(settings, seconds, seed) for seed in range(n)))


async def sample_for(fleet: Fleet, seconds: float) -> list[Sample]:
    """Sample the servers every second."""
    samples = [await asyncio.to_thread(fleet.sample)]
    until = time.monotonic() + seconds
    while time.monotonic() < until:
        await asyncio.sleep(SAMPLE_EVERY_S)
        samples.append(await asyncio.to_thread(fleet.sample))
    return samples


async def beside(
    fleet: Fleet, crowd: Crowd, n_slow: int, seconds: float
) -> tuple[list[Sample], list[Sample], list[Stopped]]:
    """Sample players alone, then beside pages that stop reading."""
    await asyncio.to_thread(crowd.counts)  # answered once the players have arrived
    await asyncio.sleep(5.0)
    alone = await sample_for(fleet, seconds)
    stopping = asyncio.create_task(stop_many(fleet.settings, n_slow, seconds))
    together = await sample_for(fleet, seconds)
    return alone, together, await stopping


def late_between(samples: list[Sample]) -> Lateness:
    """Return the lateness of frames between the first and the last sample."""
    return samples[-1].lateness - samples[0].lateness


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--slow", type=int, default=20, help="pages that stop reading")
    parser.add_argument("--players", type=int, default=8, help="players beside them")
    parser.add_argument("--seconds", type=float, default=60.0)
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="tril-slow-") as folder:
        workplace = make_workplace(Path(folder) / "data")
        workplace.database.close()
        n_games = arguments.slow + 2 * arguments.players
        with (
            running_fleet(workplace.settings.data, 1, n_games) as fleet,
            running_crowd(fleet.settings, arguments.players, 1) as crowd,
        ):
            alone, together, stopped = asyncio.run(
                beside(fleet, crowd, arguments.slow, arguments.seconds)
            )
    print(f"{'':34}{'late p50':>10}{'p99 ms':>8}{'MB first':>10}{'last':>7}{'most':>7}")
    rows = {}
    for name, samples in (("players alone", alone), ("beside pages that stopped", together)):
        late = late_between(samples)
        megabytes = [sample.rss_bytes / 1e6 for sample in samples]
        rows[name] = {
            "late_p50_ms": late.percentile_ms(0.5),
            "late_p99_ms": late.percentile_ms(0.99),
            "first_mb": round(megabytes[0], 1),
            "last_mb": round(megabytes[-1], 1),
            "most_mb": round(max(megabytes), 1),
        }
        row = rows[name]
        print(
            f"{name:34}{row['late_p50_ms'] or 0:10}{row['late_p99_ms'] or 0:8}{row['first_mb']:10}"
            f"{row['last_mb']:7}{row['most_mb']:7}"
        )
    in_flight = [page.in_flight for page in stopped]
    n_closed = sum(page.is_closed for page in stopped)
    print(f"\nframes in flight to a page that stopped: at most {max(in_flight)}, ", end="")
    print(f"allowed {MAX_UNACKNOWLEDGED}; {n_closed} of {len(stopped)} connections were closed")
    print(
        json.dumps(
            {
                "benchmark": "slow_client",
                **vars(arguments),
                "in_flight": max(in_flight),
                "closed": n_closed,
                **rows,
            }
        )
    )


if __name__ == "__main__":
    main()
