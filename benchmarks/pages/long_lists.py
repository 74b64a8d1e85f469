"""How soon the pages answer when a behaviour has many recordings.

    python -m benchmarks.pages.long_lists [--recordings 20000] [--ranked 300]

Writes recordings into a data folder of its own, most of them unranked, serves them and opens the
page of the recordings and that of the ranking in Chromium. Times are from the navigation, the click
or the choice until the page shows the answer in its next picture, the processor's time is that of
server and browser together, which other load on the machine changes little; the heap is that of
JavaScript, before and after its garbage was collected. At last somebody else marks a recording as
perfect that is in sight, and what the page receives thereafter is counted, as it is on the wire.
"""

from __future__ import annotations

import argparse
import json
import tempfile
import time
from pathlib import Path
from typing import Final

import numpy as np
import psutil
from playwright.sync_api import CDPSession, Page, sync_playwright
from sqlalchemy import insert, select

from benchmarks.pages.long_runs import page_of, until_drawn
from server.web.pages import FRONTEND
from testsupport.browser import launch_chromium
from testsupport.live import LiveServer, live_server
from testsupport.workplace import Workplace, make_workplace
from tril.store import rankings, recordings
from tril.store.models import RecordingRow, Source

AFTER_EDIT_S: Final = 4.0
"""How long is listened after somebody else's edit: changes are told every half second."""

BUTTONS = "[...document.querySelectorAll('button')].map((one) => one.textContent)"
RECORDINGS = (
    "recordings",
    "document.querySelectorAll('article img').length > 0",
    f"{BUTTONS}.includes('Select all shown')",
)
RANK = (
    "rank",
    "document.querySelectorAll('section[aria-label^=Unranked] article').length > 0",
    f"{BUTTONS}.includes('Place by comparing')",
)
"""Pages, when the newest recordings can be used, and when what is about all of them can be, too."""
SELECT = '[aria-label^="Select Recording"]'
NODES = "document.querySelectorAll('*').length"


def write_recordings(workplace: Workplace, number: int, n_ranked: int) -> list[int]:
    """Write recordings that hit different aliens, and rank some; return their ids."""
    rng = np.random.default_rng(0)
    with workplace.database.writing() as session:
        row = recordings.get(session, workplace.ranked[0])
        columns = [one.key for one in RecordingRow.__table__.columns if one.key != "id"]
        copied = {name: getattr(row, name) for name in columns} | {"perfect": False}
        values = []
        for place in range(number - len(workplace.ranked)):
            cells = rng.permutation(36)[: rng.integers(0, 8)]
            taken = [[int(cell) // 6, int(cell) % 6, 30 * at] for at, cell in enumerate(cells)]
            source = Source.PERSON if place % 3 else Source.SCRIPTED
            counters = {"shots": len(taken) + 3}
            own = {"number": len(workplace.ranked) + place + 1}  # Its id: ids are given in turn.
            values.append(copied | own | {"taken": taken, "source": source, "counters": counters})
        session.execute(insert(RecordingRow), values)
        ids = list(session.scalars(select(RecordingRow.id).order_by(RecordingRow.id.desc())))
        tiers = [[key] for key in ids[-n_ranked:]]
        revision = rankings.current(session, workplace.behaviour_id).revision
        rankings.save(session, workplace.behaviour_id, revision, tiers)
    return ids


def processor_s() -> float:
    """Return the processor time of this process, which serves, and of the browser so far."""
    this = psutil.Process()
    return sum(sum(one.cpu_times()[:2]) for one in (this, *this.children(recursive=True)))


def heap_mb(devtools: CDPSession) -> float:
    """Return the size of the heap of JavaScript."""
    metrics = devtools.send("Performance.getMetrics")["metrics"]
    (used,) = [one["value"] for one in metrics if one["name"] == "JSHeapUsedSize"]
    return float(used) / 1e6


def measure(
    page: Page, server: LiveServer, which: tuple[str, str, str], behaviour_id: int
) -> dict[str, float]:
    """Return the figures of one of the pages."""
    name, usable, complete = which
    found: dict[str, float] = {}
    devtools = page.context.new_cdp_session(page)
    devtools.send("Performance.enable")
    devtools.send("Network.enable")
    received: list[float] = []
    devtools.on(
        "Network.loadingFinished", lambda event: received.append(event["encodedDataLength"])
    )
    page.goto("about:blank")
    path = f"/behaviours/{behaviour_id}/{name}"
    spent = processor_s()
    found["usable, s"] = until_drawn(page, lambda: page.goto(path, wait_until="commit"), usable)
    rest = until_drawn(page, lambda: None, complete)
    found["all of it usable, s"] = found["usable, s"] + rest
    found["processor until then, s"] = processor_s() - spent
    found["received, kB"] = sum(received) / 1e3
    found["DOM nodes"] = page.evaluate(NODES)
    found["heap, MB"] = heap_mb(devtools)
    devtools.send("HeapProfiler.collectGarbage")
    found["heap after collection, MB"] = heap_mb(devtools)
    checked = f"[...document.querySelectorAll('{SELECT}')].some((one) => one.checked)"
    found["a checkbox, s"] = until_drawn(
        page, lambda: page.evaluate(f"document.querySelector('{SELECT}').click()"), checked
    )
    if name == "recordings":
        found |= filters(page)
    first = page.evaluate(f"document.querySelector('{SELECT}').getAttribute('aria-label')")
    received.clear()
    key = first.rpartition(" ")[2]
    server.http.patch(f"/api/recordings/{key}", json={"perfect": True}).raise_for_status()
    began = time.monotonic()
    while time.monotonic() - began < AFTER_EDIT_S:
        page.wait_for_timeout(100)
    found["received after an edit elsewhere, kB"] = sum(received) / 1e3
    server.http.patch(f"/api/recordings/{key}", json={"perfect": False}).raise_for_status()
    return found


def filters(page: Page) -> dict[str, float]:
    """Return the seconds of an order, a filter, and of selecting all."""
    found = {}
    heading = "document.querySelector('article').getAttribute('aria-label')"
    order = page.get_by_label("Order")
    first = page.evaluate(heading)
    found["another order, s"] = until_drawn(
        page,
        lambda: order.select_option("oldest"),
        f"document.querySelector('article') && {heading} !== {json.dumps(first)}",
    )
    order.select_option("newest")
    shown = (
        "document.querySelector('[aria-label=\"Selected recordings\"] [role=status]').textContent"
    )
    before = page.evaluate(shown)
    found["a filter, s"] = until_drawn(
        page,
        lambda: page.get_by_label("Targets").select_option("2"),
        f"{shown} !== {json.dumps(before)}",
    )
    page.get_by_label("Targets").select_option("")
    everything = page.get_by_role("button", name="Select all shown")
    if everything.count():
        before = page.evaluate(shown)
        found["select all, s"] = until_drawn(
            page, lambda: everything.click(), f"{shown} !== {json.dumps(before)}"
        )
        page.get_by_role("button", name="Select none").click()
    return found


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--recordings", type=int, default=20_000)
    parser.add_argument("--ranked", type=int, default=300)
    parser.add_argument("--times", type=int, default=3, help="that each page is measured")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="tril-long-lists-") as folder:
        workplace = make_workplace(Path(folder) / "data")
        write_recordings(workplace, arguments.recordings, arguments.ranked)
        with (
            live_server(workplace.settings.data, frontend=FRONTEND) as server,
            sync_playwright() as playwright,
            launch_chromium(playwright) as browser,
        ):
            figures = {}
            for which in (RECORDINGS, RANK):
                rounds = [
                    measure(page_of(browser, server), server, which, workplace.behaviour_id)
                    for _ in range(arguments.times)
                ]
                figures[which[0]] = {key: [one[key] for one in rounds] for key in rounds[0]}
        workplace.database.close()
    for name, several in figures.items():
        print(f"\n| {name} | median | highest |\n|---|---:|---:|")
        for key, values in several.items():
            print(f"| {key} | {np.median(values):,.2f} | {max(values):,.2f} |")
    print(json.dumps(figures))


if __name__ == "__main__":
    main()
