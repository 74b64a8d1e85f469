"""How soon the pages of runs answer when there are many long runs.

    python -m benchmarks.pages.long_runs [--runs 100] [--points 100000]

Writes finished runs with long curves into a data folder of its own (at the given sizes ten million
points, 2 GB, two minutes), serves them and opens the pages in Chromium. Each time is from the
navigation, or from the key, until the page shows the answer in its next picture: the list of runs,
the list after a word was typed into its search, a run's curves, these zoomed in, ten runs
compared. At last a run that is at work says how far it is, and the page's title is watched: how far
behind live progress is. Prints a table of medians and the slowest of each, and JSON.
"""

from __future__ import annotations

import argparse
import json
import re
import tempfile
import time
import uuid
from collections.abc import Callable
from pathlib import Path
from typing import Final

import numpy as np
from playwright.sync_api import Browser, Page, expect, sync_playwright
from sqlalchemy import text

from server.web.pages import FRONTEND
from testsupport.browser import launch_chromium
from testsupport.finished_runs import make_finished_run
from testsupport.live import LiveServer, cookie, live_server
from testsupport.workplace import Workplace, make_workplace
from tril.store.models import RunRow
from tril.store.training import leases

STEPS_PER_POINT = 2_048
COMPARED = 10
REPORTED = (0.2, 0.4, 0.6, 0.8)
"""Shares of the reward's training; nearer ones may round to the same percent of a run."""
TIMEOUT_S: Final = 120.0

CURVES = (
    "entropy",
    "kl",
    "kl_to_start",
    "value_loss",
    "shaped_return",
    "predicted_return",
    "episode_steps",
    "death_rate",
    "hits",
    "strays",
    "steps_per_s",
)

POINTS = """
WITH RECURSIVE numbers(n) AS (SELECT 1 UNION ALL SELECT n + 1 FROM numbers WHERE n < :points)
INSERT INTO metrics (run_id, stage, step, "values", created_at)
SELECT :run_id, 'imitator', n * :steps_per_point, json_object({values}), :now FROM numbers
"""


def write_runs(workplace: Workplace, n_runs: int, n_points: int) -> list[str]:
    """Write finished runs with long curves; return their ids."""
    made = make_finished_run(workplace)
    ids = [made, *(str(uuid.uuid4()) for _ in range(n_runs - 1))]
    columns = [one.name for one in RunRow.__table__.columns if one.name != "id"]
    names = ", ".join(f'"{name}"' for name in columns)
    copy = text(f"INSERT INTO runs (id, {names}) SELECT :copy, {names} FROM runs WHERE id = :made")
    values = ", ".join(f"'{name}', abs(random() % 1000) / 1000.0" for name in CURVES)
    points = text(POINTS.format(values=values))
    with workplace.database.writing() as session:
        for run_id in ids:
            if run_id != made:
                session.execute(copy, {"copy": run_id, "made": made})
            session.execute(text("DELETE FROM metrics WHERE run_id = :run"), {"run": run_id})
            session.execute(
                points,
                {
                    "run_id": run_id,
                    "points": n_points,
                    "steps_per_point": STEPS_PER_POINT,
                    "now": "2026-01-01 00:00:00",
                },
            )
    return ids


def page_of(browser: Browser, server: LiveServer) -> Page:
    """Return a signed-in page."""
    address = f"http://{server.authority}"
    context = browser.new_context(
        base_url=address, viewport={"width": 1280, "height": 900}, reduced_motion="reduce"
    )
    name, value = cookie(server.settings).split("=", 1)
    context.add_cookies([{"name": name, "value": value, "url": address}])
    page = context.new_page()
    page.set_default_timeout(1000 * TIMEOUT_S)
    return page


def until_drawn(page: Page, begin: Callable[[], object], shown: str) -> float:
    """Return the seconds from an action until a JavaScript expression holds and is drawn."""
    began = time.monotonic()
    begin()
    page.evaluate(
        f"""() => new Promise((resolve) => {{
          const look = () => ({shown}) ? requestAnimationFrame(() => setTimeout(resolve))
            : requestAnimationFrame(look);
          look();
        }})"""
    )
    return time.monotonic() - began


CHARTS = "document.querySelectorAll('figure canvas').length >= 3"
FIRST_OF_CHART = (
    "Number(document.querySelector('figure [role=slider]').getAttribute('aria-valuemin'))"
)


def measure(page: Page, behaviour_id: int, runs: list[str]) -> dict[str, float]:
    """Return the seconds of each answer, once."""
    found: dict[str, float] = {}

    def go(path: str) -> Callable[[], object]:
        return lambda: page.goto(path, wait_until="commit")

    rows = "document.querySelectorAll('table[aria-label=Runs] tbody tr').length"
    page.goto("about:blank")
    path = f"/behaviours/{behaviour_id}/runs"
    found["list of runs"] = until_drawn(page, go(path), f"{rows} >= {len(runs)}")
    search = page.get_by_role("searchbox")
    found["search in it"] = until_drawn(page, lambda: search.fill("nothing"), f"{rows} === 0")
    page.goto("about:blank")
    found["a run's curves"] = until_drawn(page, go(f"/runs/{runs[1]}"), CHARTS)
    chart = page.locator("figure [role=slider]").first
    chart.focus()
    before = page.evaluate(FIRST_OF_CHART)
    zoomed = f"{FIRST_OF_CHART} > {before}"
    found["zoom"] = until_drawn(page, lambda: page.keyboard.press("+"), zoomed)
    page.goto("about:blank")
    query = "&".join(f"run={run_id}" for run_id in runs[:COMPARED])
    found["ten runs compared"] = until_drawn(page, go(f"/runs/compare?{query}"), CHARTS)
    return found


def live_delays(page: Page, workplace: Workplace) -> list[float]:
    """Return the seconds from some reports of a new run to the titles that say them."""
    run_id = workplace.make_run()
    lease = workplace.lease(run_id)
    page.goto(f"/runs/{run_id}")
    expect(page).to_have_title(re.compile("%"))
    delays = []
    for done in REPORTED:

        def report(done: float = done) -> None:
            with workplace.database.writing() as session:
                leases.report(session, lease, "reward", done, 60.0)

        before = page.title()
        shown = f"document.title !== {json.dumps(before)} && document.title.includes('%')"
        delays.append(until_drawn(page, report, shown))
    return delays


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--runs", type=int, default=100)
    parser.add_argument("--points", type=int, default=100_000, help="of each run")
    parser.add_argument("--times", type=int, default=5, help="that each is measured")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="tril-long-runs-") as folder:
        workplace = make_workplace(Path(folder) / "data")
        runs = write_runs(workplace, arguments.runs, arguments.points)
        with (
            live_server(workplace.settings.data, frontend=FRONTEND) as server,
            sync_playwright() as playwright,
            launch_chromium(playwright) as browser,
        ):
            page = page_of(browser, server)
            rounds = [measure(page, workplace.behaviour_id, runs) for _ in range(arguments.times)]
            seconds = {name: [one[name] for one in rounds] for name in rounds[0]}
            seconds["progress, live"] = [
                delay for _ in range(arguments.times) for delay in live_delays(page, workplace)
            ]
        workplace.database.close()
    print("| what | median, s | slowest, s |\n|---|---|---|")
    for name, several in seconds.items():
        print(f"| {name} | {np.median(several):.2f} | {max(several):.2f} |")
    print(json.dumps(seconds))


if __name__ == "__main__":
    main()
