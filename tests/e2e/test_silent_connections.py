"""The pages in a real browser while their connections go silent without being closed."""

from __future__ import annotations

import re
import time
from collections.abc import Iterator

import pytest
from playwright.sync_api import Browser, Page, expect

from tests.e2e.pages import DESKTOP, watched_page
from tests.e2e.playing import FULL_TIME, expect_running
from testsupport.live import LiveServer, cookie
from testsupport.silent_proxy import SilentProxy, silent_proxy

LOST = "Connection lost"
NOTICED_MS = 3_500
"""The page promises 3 s; the rest is for a machine with other work."""
PATIENCE_MS = 30_000
REOPENED_MS = 60_000
"""The browser keeps up to six connections, and tries each of them."""


@pytest.fixture
def proxy(built: LiveServer) -> Iterator[SilentProxy]:
    """Return a proxy before the server with the built pages."""
    with silent_proxy(built.settings.port) as proxy:
        yield proxy


@pytest.fixture
def page(browser: Browser, built: LiveServer, proxy: SilentProxy) -> Iterator[Page]:
    """Return the play page of column 1 behind the proxy."""
    address = f"http://127.0.0.1:{proxy.port}"
    context = browser.new_context(base_url=address, viewport=DESKTOP)
    name, value = cookie(built.settings).split("=", 1)
    context.add_cookies([{"name": name, "value": value, "url": address}])
    with watched_page(context, "/behaviours/1/play") as page:
        yield page


def look_for(page: Page, words: str) -> None:
    """Note from now on whether a page shows words, however briefly."""
    page.evaluate(
        """(words) => {
          window.seen = false;
          const look = () => { window.seen ||= document.body.innerText.includes(words); };
          const all = { subtree: true, childList: true, characterData: true, attributes: true };
          new MutationObserver(look).observe(document.body, all);
        }""",
        words,
    )


def expect_seen(page: Page, timeout_ms: float) -> None:
    """Wait until the page has shown what is looked for."""
    page.wait_for_function("() => window.seen", timeout=timeout_ms)


def time_left(page: Page) -> str:
    """Return the time left as it is shown."""
    return page.get_by_role("timer", name="Time left").inner_text()


def test_a_game_goes_on_over_a_new_connection(page: Page, proxy: SilentProxy) -> None:
    page.get_by_role("button", name="Start game").click()
    expect_running(page)
    look_for(page, LOST)
    proxy.silence()
    expect_seen(page, NOTICED_MS)
    standing = time_left(page)
    expect(page.get_by_text(LOST)).to_be_hidden()
    expect_running(page)
    expect(page.get_by_role("timer", name="Time left")).not_to_have_text(standing)
    page.get_by_role("button", name="End the game here").click()
    expect(page.get_by_role("button", name="Keep K")).to_be_visible()


def test_a_paused_game_stays_paused(page: Page, proxy: SilentProxy) -> None:
    page.get_by_role("button", name="Start game").click()
    expect_running(page)
    page.keyboard.press("Escape")
    resume = page.get_by_role("button", name="Resume").first
    expect(resume).to_be_visible()
    standing = time_left(page)
    assert standing != FULL_TIME
    look_for(page, LOST)
    proxy.silence()
    expect_seen(page, NOTICED_MS)
    expect(resume).to_be_visible(timeout=PATIENCE_MS)
    page.wait_for_timeout(1_000)
    assert time_left(page) == standing


def test_the_status_is_no_longer_green_and_changes_arrive_again(
    page: Page, built: LiveServer, proxy: SilentProxy
) -> None:
    status = page.get_by_role("button", name="Processes and disk")
    expect(status).to_contain_text("Worker")
    look_for(page, "No connection")
    proxy.silence()
    expect_seen(page, PATIENCE_MS)
    expect(status).to_contain_text("Worker", timeout=REOPENED_MS)
    name = f"Renamed {time.time_ns()}"
    built.http.patch("/api/player", json={"name": name})
    expect(page.get_by_role("button", name=re.compile(name))).to_be_visible(timeout=PATIENCE_MS)
