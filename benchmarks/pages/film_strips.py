"""How soon 200 games are seen on the rank page, and what their film strips cost.

    python -m benchmarks.pages.film_strips [--games 200]

Writes recordings that all differ into a data folder of its own, ranks them in tiers of four, makes
their film strips and opens the page in a window that is high enough for all of them. Times are from
the navigation until all cards are there, and from then until all pictures are drawn; the browser
has none of them.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from pathlib import Path
from typing import Final

import numpy as np
from playwright.sync_api import sync_playwright

from benchmarks.pages.long_runs import page_of, until_drawn
from server.play.replays.strip import Reel
from server.web.pages import FRONTEND
from testsupport.browser import launch_chromium
from testsupport.live import LiveServer, live_server
from testsupport.workplace import Workplace, make_workplace
from tril.demonstrators import play_varied
from tril.games.space_invaders import SPACE_INVADERS
from tril.recording import replay
from tril.store import rankings, recordings
from tril.store.models import Source

WINDOW: Final = {"width": 2560, "height": 15_000}
TIER_OF: Final = 4
TIMES: Final = 3


def write_games(workplace: Workplace, number: int) -> list[int]:
    """Write games of different lengths, rank them and return their ids."""
    game = SPACE_INVADERS.make_console()
    whole = play_varied(np.random.default_rng(0), game).recording
    with workplace.database.writing() as session:
        ids = []
        for length in range(whole.n_frames - number, whole.n_frames):
            played = replay(whole.until(length), game)
            row = recordings.add(
                session, workplace.behaviour_id, whole.until(length), played, Source.PERSON
            )
            ids.append(row.id)
        tiers = [ids[first : first + TIER_OF] for first in range(0, number, TIER_OF)]
        revision = rankings.current(session, workplace.behaviour_id).revision
        rankings.save(session, workplace.behaviour_id, revision, tiers)
    return ids


def make_strips(server: LiveServer, ids: list[int]) -> list[int]:
    """Request the film strips of games, one after the other, and return their bytes."""
    answers = [server.http.get(f"/api/recordings/{key}/strip.webp") for key in ids]
    return [len(answer.raise_for_status().content) for answer in answers]


def cost_ms() -> tuple[float, float]:
    """Return the milliseconds of a replay, and how many more it takes with a film strip."""
    console = SPACE_INVADERS.make_console()
    recording = play_varied(np.random.default_rng(1), console).recording
    plain, filmed = [], []
    for _ in range(5):
        began = time.perf_counter()
        replay(recording, console)
        plain.append(time.perf_counter() - began)
        began = time.perf_counter()
        reel = Reel(recording)
        replay(recording, console, reel.add)
        reel.webp()
        filmed.append(time.perf_counter() - began)
    return 1000 * min(plain), 1000 * (min(filmed) - min(plain))


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--games", type=int, default=200)
    number = parser.parse_args().games
    plain_ms, more_ms = cost_ms()
    print(f"a replay, ms: {plain_ms:.0f}; more with its film strip: {more_ms:.0f}")
    images = (
        "[...document.querySelectorAll('article img')]"
        ".filter((one) => one.getBoundingClientRect().top < innerHeight)"
    )
    cards = f"{images}.length >= {number}"
    seen = f"{images}.every((one) => one.complete && one.naturalWidth > 0)"
    with tempfile.TemporaryDirectory(prefix="tril-film-strips-") as folder:
        workplace = make_workplace(Path(folder) / "data")
        ids = write_games(workplace, number)
        with (
            live_server(workplace.settings.data, frontend=FRONTEND) as server,
            sync_playwright() as playwright,
            launch_chromium(playwright) as browser,
        ):
            began = time.monotonic()
            sizes = make_strips(server, ids)
            print(f"strips made, s: {time.monotonic() - began:.1f}")
            print(f"bytes a strip, median and highest: {np.median(sizes):.0f}, {max(sizes)}")
            for _ in range(TIMES):
                page = page_of(browser, server)
                page.set_viewport_size({"width": WINDOW["width"], "height": WINDOW["height"]})
                path = f"/behaviours/{workplace.behaviour_id}/rank"

                def go(path: str = path) -> None:
                    page.goto(path, wait_until="commit")  # noqa: B023

                usable = until_drawn(page, go, cards)
                rest = until_drawn(page, lambda: None, seen)
                print(f"cards, s: {usable:.2f}; pictures after, s: {rest:.2f}")
                page.context.close()
        workplace.database.close()


if __name__ == "__main__":
    main()
