"""What Lighthouse says of the main pages: performance and accessibility, of 100.

    python -m benchmarks.pages.lighthouse [--form mobile] [--rounds 3] [--pages run recording]

Serves a data folder of its own with a finished run, signs in with Chromium, and has Lighthouse load
each page anew, without a cache: as a desktop, or as a phone on a slow network whose processor takes
four times as long. The first call downloads Lighthouse from npm; it is too large (185 MB) to be
installed for everybody. Performance is the median over the rounds. Prints a table with what the
last round's performance is made of, what costs points, and JSON.
"""

from __future__ import annotations

import argparse
import json
import socket
import statistics
import subprocess
import tempfile
from pathlib import Path
from typing import Any

from playwright.sync_api import sync_playwright

from server.web.pages import FRONTEND
from testsupport.browser import ARGUMENTS, find_chromium, install_chromium
from testsupport.finished_runs import make_finished_run
from testsupport.live import cookie, live_server
from testsupport.watching import running_inference
from testsupport.workplace import make_workplace

LIGHTHOUSE = "lighthouse@12.8.2"
CATEGORIES = ("performance", "accessibility")
GOOD = 95
METRICS = {
    "FCP": "first-contentful-paint",
    "LCP": "largest-contentful-paint",
    "TBT": "total-blocking-time",
    "CLS": "cumulative-layout-shift",
    "SI": "speed-index",
}
ROOT = Path(__file__).parents[2]


def free_port() -> int:
    """Return a port that nobody listens on."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port: int = probe.getsockname()[1]
        return port


def pages_of(run_id: str) -> dict[str, str]:
    """Return the paths of the main pages by name."""
    return {
        "behaviours": "/",
        "play": "/behaviours/1/play",
        "recordings": "/behaviours/1/recordings",
        "rank": "/behaviours/1/rank",
        "train": "/behaviours/1/train",
        "runs": "/behaviours/1/runs",
        "run": f"/runs/{run_id}",
        "recording": "/recordings/1",
    }


def audit(url: str, port: int, form: str) -> dict[str, Any]:
    """Return Lighthouse's report on a page that a signed-in browser shows."""
    preset = ["--preset=desktop"] if form == "desktop" else []
    command = [
        str(ROOT / "scripts" / "with_node.sh"),
        *("npx", "--yes", LIGHTHOUSE, url),
        *(f"--port={port}", "--output=json", "--quiet", *preset),
        f"--only-categories={','.join(CATEGORIES)}",
    ]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        raise RuntimeError(f"Lighthouse failed on {url}: {done.stderr[-2000:]}")
    report: dict[str, Any] = json.loads(done.stdout)
    return report


def scores(report: dict[str, Any]) -> dict[str, int]:
    """Return the score of each category, of 100."""
    return {name: round(100 * report["categories"][name]["score"]) for name in CATEGORIES}


def metrics(report: dict[str, Any]) -> str:
    """Return the metrics of the performance score, and the largest element."""
    audits = report["audits"]
    values = [f"{name} {audits[audit]['displayValue']}" for name, audit in METRICS.items()]
    largest = audits["largest-contentful-paint-element"].get("details", {}).get("items", [])
    shown = [row["node"]["snippet"] for table in largest for row in table["items"] if "node" in row]
    return ", ".join([*values, *shown[:1]])


def losses(report: dict[str, Any]) -> list[str]:
    """Return the titles of the audits that cost a page points."""
    counted = [
        one["id"]
        for name in CATEGORIES
        for one in report["categories"][name]["auditRefs"]
        if one["weight"]
    ]
    audits = report["audits"]
    below = [audits[one] for one in counted if (audits[one]["score"] or 0) < GOOD / 100]
    return [
        f"{one['title']} {one.get('displayValue', '')}".strip()
        for one in below
        if one["scoreDisplayMode"] in {"binary", "numeric", "metricSavings"}
    ]


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--form", choices=("desktop", "mobile"), default="desktop")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--pages", nargs="*", default=(), help="all by default")
    arguments = parser.parse_args()
    install_chromium()
    found: dict[str, dict[str, int]] = {}
    reasons: dict[str, list[str]] = {}
    with tempfile.TemporaryDirectory(prefix="tril-lighthouse-") as folder:
        workplace = make_workplace(Path(folder) / "data")
        pages = pages_of(make_finished_run(workplace))
        port = free_port()
        with (
            live_server(workplace.settings.data, frontend=FRONTEND) as server,
            running_inference(workplace),
            sync_playwright() as playwright,
            playwright.chromium.launch_persistent_context(
                Path(folder) / "profile",
                executable_path=find_chromium(),
                args=[*ARGUMENTS, "--no-sandbox", f"--remote-debugging-port={port}"],
            ) as context,
        ):
            address = f"http://{server.authority}"
            name, value = cookie(server.settings).split("=", 1)
            context.add_cookies([{"name": name, "value": value, "url": address}])
            for title, path in pages.items():
                if arguments.pages and title not in arguments.pages:
                    continue
                reports = [
                    audit(address + path, port, arguments.form) for _ in range(arguments.rounds)
                ]
                rounds = [scores(one) for one in reports]
                found[title] = {
                    name: round(statistics.median(one[name] for one in rounds))
                    for name in CATEGORIES
                }
                reasons[title] = losses(reports[-1])
                print(
                    f"{title:12}",
                    *(f"{name} {found[title][name]}" for name in CATEGORIES),
                    metrics(reports[-1]),
                    flush=True,
                )
        workplace.database.close()
    for title, lost in reasons.items():
        if min(found[title].values()) < GOOD:
            print(f"\n{title}: " + "; ".join(lost))
    print(json.dumps({"benchmark": "lighthouse", **vars(arguments), "pages": found}))


if __name__ == "__main__":
    main()
