"""Every page in a real browser, without a violation that axe-core finds."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Browser, Page, ViewportSize, expect

from server.web.pages import FRONTEND
from tests.e2e.pages import signed_in
from tests.e2e.playing import expect_running
from testsupport.finished_runs import make_finished_run
from testsupport.live import LiveServer, live_server
from testsupport.workplace import Workplace, make_workplace
from tril.store.models import RunStatus
from tril.store.training import leases

AXE = Path(__file__).parents[2] / "frontend" / "node_modules" / "axe-core" / "axe.min.js"
KEEP = re.compile("^Keep")
RULES = ("wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "wcag22aa", "best-practice")
RUN = f"async () => (await axe.run({{runOnly: {json.dumps(RULES)}}})).violations"

SCREENS: dict[str, dict[str, Any]] = {
    "light": {
        "viewport": ViewportSize(width=1280, height=900),
        "color_scheme": "light",
        "reduced_motion": "reduce",
    },
    "dark phone": {
        "viewport": ViewportSize(width=360, height=740),
        "color_scheme": "dark",
        "reduced_motion": "reduce",
        "has_touch": True,
        "is_mobile": True,
    },
}


@pytest.fixture(scope="module")
def used(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[LiveServer, list[str]]]:
    """Return a running server with a ranking, and a finished, a stopped and a waiting run."""
    workplace = make_workplace(tmp_path_factory.mktemp("axe") / "data")
    done = make_finished_run(workplace)
    stopped = _stopped(workplace)
    waiting = workplace.make_run()
    with live_server(workplace.settings.data, frontend=FRONTEND) as running:
        yield running, [done, stopped, waiting]
    workplace.database.close()


def _stopped(workplace: Workplace) -> str:
    run_id = workplace.make_run()
    lease = workplace.lease(run_id)
    with workplace.database.writing() as session:
        leases.end(session, lease, RunStatus.STOPPED, "There is nothing to learn.")
    return run_id


def violations(page: Page) -> list[str]:
    """Return what axe-core objects to, with the first element of each."""
    page.evaluate(AXE.read_text())
    found = page.evaluate(RUN)
    return [f"{one['id']}: {one['help']}: {one['nodes'][0]['html'][:200]}" for one in found]


def settled(page: Page, path: str) -> None:
    """Go to a page and wait until it shows what it has."""
    page.goto(path)
    expect(page.locator("h1, h2").first).to_be_visible()
    expect(page.locator("[aria-busy=true]")).to_have_count(0)


@pytest.mark.parametrize("screen", SCREENS)
def test_no_page_has_a_violation(
    browser: Browser, used: tuple[LiveServer, list[str]], screen: str
) -> None:
    server, (done, stopped, waiting) = used
    paths = [
        "/",
        "/behaviours/1/play",
        "/behaviours/1/recordings",
        "/behaviours/1/rank",
        "/behaviours/1/train",
        "/behaviours/1/runs",
        "/behaviours/2/rank",
        "/recordings/1",
        f"/runs/{done}",
        f"/runs/{stopped}",
        f"/runs/{waiting}",
        f"/runs/compare?run={done}&run={stopped}",
        "/nowhere",
    ]
    found = {}
    with signed_in(browser, server, "/", **SCREENS[screen]) as page:
        for path in paths:
            settled(page, path)
            found[path] = violations(page)
    assert {path: ones for path, ones in found.items() if ones} == {}


@pytest.mark.parametrize("screen", SCREENS)
def test_a_game_and_the_dialogs_have_no_violation(
    browser: Browser, used: tuple[LiveServer, list[str]], screen: str
) -> None:
    server, (done, *_) = used
    found = {}
    with signed_in(browser, server, "/behaviours/1/play", **SCREENS[screen]) as page:
        page.get_by_role("button", name="Start game").click()
        expect_running(page)
        page.get_by_role("button", name="Pause").click()
        found["paused"] = violations(page)
        page.get_by_role("button", name="End the game here").click()
        expect(page.get_by_role("button", name=KEEP)).to_be_visible()
        found["ended"] = violations(page)
        page.get_by_role("button", name=KEEP).click()
        page.keyboard.press("?")
        expect(page.get_by_role("dialog")).to_be_visible()
        found["keys"] = violations(page)
        settled(page, "/")
        page.get_by_role("button", name="New behaviour").first.click()
        expect(page.get_by_role("dialog")).to_be_visible()
        found["new behaviour"] = violations(page)
        settled(page, f"/runs/{done}")
        page.get_by_role("button", name="Player").click()
        found["player"] = violations(page)
    assert {state: ones for state, ones in found.items() if ones} == {}


def test_who_is_not_signed_in_finds_no_violation(
    browser: Browser, used: tuple[LiveServer, list[str]]
) -> None:
    server, _ = used
    context = browser.new_context(**SCREENS["light"])
    page = context.new_page()
    page.goto(f"http://{server.authority}/")
    expect(page.get_by_role("textbox")).to_be_visible()
    assert violations(page) == []
    context.close()
