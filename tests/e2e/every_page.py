"""Every page of a Tril in use: ranked games, a finished, a stopped and a waiting run."""

from __future__ import annotations

import atexit
import re
import shutil
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from playwright.sync_api import Page, expect

from server.web.pages import FRONTEND
from testsupport.finished_runs import make_finished_run
from testsupport.live import LiveServer, live_server
from testsupport.watching import running_inference
from testsupport.workplace import Workplace, copy_of, make_workplace
from tril.store.models import RunStatus
from tril.store.training import leases

LOADING_TIMEOUT_MS = 60_000
UNCHANGED = """() => new Promise((resolve) => {
  let timer = setTimeout(resolve, 250);
  const observer = new MutationObserver(() => {
    clearTimeout(timer);
    timer = setTimeout(resolve, 250);
  });
  observer.observe(document.body, { subtree: true, childList: true });
})"""
"""Resolves once nothing was added to the page or removed from it for a quarter of a second."""


@dataclass(frozen=True)
class EveryPage:
    """A running server, and the paths of all its pages by name."""

    server: LiveServer
    paths: Mapping[str, str]


@contextmanager
def serving_every_page(data: Path) -> Iterator[EveryPage]:
    """Serve a data folder of its own, with everything that the pages show, for a block."""
    filled = _filled()
    workplace = copy_of(filled.workplace, data)
    with (
        running_inference(workplace),
        live_server(workplace.settings.data, frontend=FRONTEND) as running,
    ):
        yield EveryPage(running, filled.paths)
    workplace.database.close()


@dataclass(frozen=True)
class _Filled:
    workplace: Workplace
    paths: Mapping[str, str]


@cache
def _filled() -> _Filled:
    """Return a data folder, made once and copied from then on, and the paths of its pages."""
    folder = Path(tempfile.mkdtemp(prefix="tril-tests-"))
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    workplace = make_workplace(folder)
    done = make_finished_run(workplace)
    stopped = _stopped(workplace)
    waiting = workplace.make_run()
    workplace.database.close()
    paths = {
        "behaviours": "/",
        "play": "/behaviours/1/play",
        "recordings": "/behaviours/1/recordings",
        "rank": "/behaviours/1/rank",
        "train": "/behaviours/1/train",
        "runs": "/behaviours/1/runs",
        "empty ranking": "/behaviours/2/rank",
        "recording": "/recordings/1",
        "finished run": f"/runs/{done}",
        "stopped run": f"/runs/{stopped}",
        "waiting run": f"/runs/{waiting}",
        "compared runs": f"/runs/compare?run={done}&run={stopped}",
        "people": "/people",
        "no page": "/nowhere",
    }
    return _Filled(workplace, paths)


def _stopped(workplace: Workplace) -> str:
    run_id = workplace.make_run()
    lease = workplace.lease(run_id)
    with workplace.database.writing() as session:
        leases.end(session, lease, RunStatus.STOPPED, "There is nothing to learn.")
    return run_id


def settled(page: Page, path: str) -> None:
    """Go to a page and wait until it shows what it has."""
    page.goto(path)
    expect(page.locator("h1, h2").first).to_be_visible()
    expect(page.locator("[aria-busy=true]")).to_have_count(0)
    loading = page.get_by_role("status").filter(has_text=re.compile("^Loading "))
    expect(loading).to_have_count(0, timeout=LOADING_TIMEOUT_MS)
    page.evaluate(UNCHANGED)
