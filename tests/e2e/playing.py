"""What the tests that play in a real browser share."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from playwright.sync_api import Browser, Page, expect

from tests.server.live import LiveServer, cookie

DESKTOP = {"width": 1280, "height": 900}
FULL_TIME = "20.0 s"


@contextmanager
def play_page(browser: Browser, server: LiveServer, **options: Any) -> Iterator[Page]:
    """Open the play page of column 1; errors in its console fail the test.

    Args:
        browser: The browser.
        server: A server with the built pages.
        options: Of the browser's context, as its viewport.
    """
    address = f"http://{server.authority}"
    context = browser.new_context(**options)
    name, value = cookie(server.settings).split("=", 1)
    context.add_cookies([{"name": name, "value": value, "url": address}])
    page = context.new_page()
    problems: list[str] = []
    page.on("pageerror", lambda error: problems.append(str(error)))
    page.on("console", lambda m: problems.append(m.text) if m.type == "error" else None)
    page.set_default_timeout(15_000)
    page.goto(f"{address}/behaviours/1/play")
    yield page
    context.close()
    assert not problems, problems


def expect_running(page: Page) -> None:
    """Wait until the game goes: counted down, and its time running."""
    expect(page.get_by_role("timer", name="Time left")).not_to_contain_text(FULL_TIME)
    expect(page.get_by_role("button", name="Pause")).to_be_visible()
    expect(page.locator("strong[role=timer]")).to_be_hidden()


def end_and_keep(page: Page) -> int:
    """End the game and keep it; returns its recording."""
    page.get_by_role("button", name="End the game here").click()
    page.get_by_role("button", name="Keep").click()
    return kept_as(page)


def kept_as(page: Page) -> int:
    """Return the recording that the ended game was kept as."""
    said = page.get_by_text(re.compile(r"Kept as recording \d+"))
    return int(re.sub(r"\D", "", said.inner_text()))
