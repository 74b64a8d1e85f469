"""The main job in Firefox and WebKit: play, keep, rank by keyboard, train, look."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import AbstractContextManager

import pytest

from tests.e2e.every_page import EveryPage
from tests.e2e.playing import course_of
from testsupport.live import cookie
from testsupport.other_browsers import OtherBrowser, firefox, webkit
from tril.games.space_invaders.memory import Action

BROWSERS = {"Firefox": firefox, "WebKit": webkit}
COUNT_PICTURES = """(() => {
  const canvas = document.querySelector("canvas[role=img]"), seen = (window.seen ??= new Set());
  seen.add(canvas.toDataURL());
  return seen.size;
})()"""
FOCUS = """(name) => [...document.querySelectorAll("button")]
  .find((one) => one.getAttribute("aria-label") === name).focus()"""
TIME_LEFT = "[role=timer][aria-label='Time left']"
TIER_1 = """() => document.querySelector("li[aria-label^='Tier 1 of']")"""


# The first time it may have to install the browser.
@pytest.mark.timeout(1_800)
@pytest.mark.parametrize("name", BROWSERS)
def test_the_main_job(every_page: EveryPage, name: str) -> None:
    begin: Callable[[], AbstractContextManager[OtherBrowser]] = BROWSERS[name]
    try:
        browser = begin()
        with browser as page:
            _main_job(page, every_page)
    except FileNotFoundError as missing:
        pytest.skip(f"{missing} Debian's packages: firefox-esr, webkit2gtk-driver, xvfb.")


def _main_job(page: OtherBrowser, pages: EveryPage) -> None:
    base = f"http://{pages.server.authority}"
    key, value = cookie(pages.server.settings).split("=", 1)
    page.go_to(f"{base}/nowhere.txt")
    page.evaluate(f"document.cookie = '{key}={value}; path=/'")

    page.go_to(base + pages.paths["play"])
    page.click("button", "Start game")
    page.until(f"document.querySelector(\"{TIME_LEFT}\")?.innerText.includes('20.0') === false")
    for way in ("ArrowRight", "ArrowLeft", "Space"):
        page.hold(way, 0.4)
    page.until(f"{COUNT_PICTURES} > 10")
    page.click("button", "End the game here")
    page.click("button", "Keep")
    kept = page.until("document.body.innerText.match(/Kept as recording (\\d+)/)?.[1]")
    library = pages.server.http.get("/api/behaviours/1/recordings").json()
    course = course_of(
        pages.server, next(row["id"] for row in library if row["number"] == int(kept))
    )
    assert course.count(Action.RIGHT) > 10
    assert course.count(Action.LEFT) > 10
    assert Action.FIRE in course

    page.go_to(base + pages.paths["rank"])
    page.until(f"document.body.innerText.includes('Recording {kept}')")
    page.evaluate(f"({FOCUS})('Rank as best: Recording {kept}')")
    page.hold("Enter")
    page.until(f"({TIER_1})()?.innerText.includes('Recording {kept}')")
    page.until("document.body.innerText.includes('Saved')")

    page.go_to(base + pages.paths["train"])
    page.click("button", "Train")
    page.until("/^\\/runs\\/[0-9a-f-]+$/.test(location.pathname)")
    page.until("document.body.innerText.includes('Waiting')")

    page.go_to(base + pages.paths["finished run"])
    page.until("document.body.innerText.includes('The imitator hits')")
    page.until("document.querySelectorAll('figure canvas').length > 0")
    page.click("a", "Watch the imitator play")
    page.until("location.pathname.endsWith('/watch')")
    page.until("document.querySelector('article output')?.innerText.endsWith('%')")
    assert page.evaluate("document.documentElement.scrollWidth - innerWidth") <= 0
