"""Every page in a real browser, without a violation that axe-core finds."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Browser, Page, ViewportSize, expect

from tests.e2e.every_page import EveryPage, settled
from tests.e2e.pages import signed_in
from tests.e2e.playing import expect_running

AXE = Path(__file__).parents[2] / "frontend" / "node_modules" / "axe-core" / "axe.min.js"
KEEP = re.compile("^Keep( K)?$")
RULES = ("wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "wcag22aa", "best-practice")
OPTIONS = {"runOnly": RULES, "resultTypes": ["violations"]}
RUN = f"async () => (await axe.run({json.dumps(OPTIONS)})).violations"

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


def violations(page: Page) -> list[str]:
    """Return what axe-core objects to, with the first element of each."""
    if not page.evaluate("() => 'axe' in window"):
        page.evaluate(AXE.read_text())
    found = page.evaluate(RUN)
    return [f"{one['id']}: {one['help']}: {one['nodes'][0]['html'][:200]}" for one in found]


@pytest.mark.parametrize("screen", SCREENS)
def test_no_page_has_a_violation(browser: Browser, every_page: EveryPage, screen: str) -> None:
    found = {}
    with signed_in(browser, every_page.server, "/", **SCREENS[screen]) as page:
        for path in every_page.paths.values():
            settled(page, path)
            found[path] = violations(page)
    assert {path: ones for path, ones in found.items() if ones} == {}


@pytest.mark.parametrize("screen", SCREENS)
def test_a_game_and_the_dialogs_have_no_violation(
    browser: Browser, every_page: EveryPage, screen: str
) -> None:
    found = {}
    with signed_in(browser, every_page.server, "/behaviours/1/play", **SCREENS[screen]) as page:
        page.get_by_role("button", name="Start game").click()
        expect_running(page)
        page.get_by_role("button", name="Pause").click()
        found["paused"] = violations(page)
        page.get_by_role("button", name="End the game here").click()
        expect(page.get_by_role("button", name=KEEP)).to_be_visible()
        found["ended"] = violations(page)
        page.get_by_role("button", name=KEEP).click()
        settled(page, every_page.paths["rank"])
        page.get_by_role("button", name="Place by comparing").click()
        expect(page.get_by_role("img", name=re.compile("^Game screen of"))).to_have_count(2)
        found["comparison"] = violations(page)
        page.keyboard.press("w")
        expect(page.get_by_role("button", name="Back to the ranking")).to_be_focused()
        found["end of a comparison"] = violations(page)
        page.get_by_role("button", name="Back to the ranking").click()
        page.keyboard.press("?")
        expect(page.get_by_role("dialog")).to_be_visible()
        found["keys"] = violations(page)
        settled(page, "/")
        page.get_by_role("button", name="New behaviour").first.click()
        expect(page.get_by_role("dialog")).to_be_visible()
        found["new behaviour"] = violations(page)
        settled(page, every_page.paths["finished run"])
        page.get_by_role("button", name="Player").click()
        found["player"] = violations(page)
    assert {state: ones for state, ones in found.items() if ones} == {}


def test_who_is_not_signed_in_finds_no_violation(browser: Browser, every_page: EveryPage) -> None:
    context = browser.new_context(**SCREENS["light"])
    page = context.new_page()
    page.goto(f"http://{every_page.server.authority}/")
    expect(page.get_by_role("textbox")).to_be_visible()
    assert violations(page) == []
    context.close()
