"""Many tabs of one browser, and a browser that is offline for a while."""

from __future__ import annotations

import re
import time

from playwright.sync_api import Browser, Page, expect

from tests.e2e.pages import DESKTOP, signed_in
from tests.e2e.test_lost_responses import expect_order, saved_tiers
from testsupport.live import LiveServer

TABS = 10
"""More than the six connections to one host that a browser allows."""
ARRIVES_MS = 60_000
OFFLINE = "net::ERR_INTERNET_DISCONNECTED"


def rename(server: LiveServer) -> re.Pattern[str]:
    """Give the owner a new name; return it as a pattern."""
    name = f"Renamed {time.time_ns()}"
    server.http.patch("/api/player", json={"name": name}).raise_for_status()
    return re.compile(name)


def expect_name(page: Page, name: re.Pattern[str]) -> None:
    """Expect the owner's name on a page."""
    expect(page.get_by_role("button", name=name)).to_be_visible(timeout=ARRIVES_MS)


def test_all_of_many_tabs_load_and_hear_of_changes(browser: Browser, built: LiveServer) -> None:
    path = "/behaviours/1/recordings"
    with signed_in(browser, built, path, viewport=DESKTOP) as first:
        others = [first.context.new_page() for _ in range(TABS - 1)]
        for page in others:
            page.goto(path)
        for page in (first, *others):
            expect(page.get_by_role("article").first).to_be_visible(timeout=ARRIVES_MS)
        name = rename(built)
        for page in (first, *others):
            expect_name(page, name)
        # It has kept the stream for all; another one takes over.
        first.close()
        name = rename(built)
        for page in others:
            expect_name(page, name)


def test_what_was_done_offline_is_saved_and_what_was_missed_arrives(
    browser: Browser, built: LiveServer
) -> None:
    first, second, *others = saved_tiers(built)
    wanted = [second, first, *others]
    with signed_in(browser, built, "/behaviours/1/rank", OFFLINE, viewport=DESKTOP) as page:
        expect_order(page, [first, second, *others])
        page.context.set_offline(True)
        page.get_by_role("button", name=f"Down: Recording {first[0]}", exact=True).click()
        expect(page.get_by_role("alert").get_by_text("could not be saved")).to_be_visible()
        expect_order(page, wanted)
        assert saved_tiers(built) == [first, second, *others]
        name = rename(built)
        page.context.set_offline(False)
        expect(page.get_by_text("Saved", exact=True)).to_be_visible()
        assert saved_tiers(built) == wanted
        expect_name(page, name)
