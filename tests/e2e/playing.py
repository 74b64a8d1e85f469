"""What the tests that play in a real browser share."""

from __future__ import annotations

import re
from contextlib import AbstractContextManager, suppress
from typing import Any

from playwright.sync_api import Browser, Page, TimeoutError, expect

from tests.e2e.pages import signed_in
from testsupport.live import LiveServer
from tril.games.space_invaders.memory import Action

FULL_TIME = "20.0 s"


def play_page(browser: Browser, server: LiveServer, **options: Any) -> AbstractContextManager[Page]:
    """Open the play page of column 1 for a block; see signed_in."""
    return signed_in(browser, server, "/behaviours/1/play", **options)


def expect_running(page: Page) -> None:
    """Wait until the game goes: counted down, and its time running."""
    expect(page.get_by_role("timer", name="Time left")).not_to_contain_text(FULL_TIME)
    expect(page.get_by_role("button", name="Pause")).to_be_visible()
    expect(page.locator("strong[role=timer]")).to_be_hidden()


def end_and_keep(page: Page) -> int:
    """End the game, unless a bomb was quicker, and keep it; returns its recording."""
    keep = page.get_by_role("button", name="Keep K")
    while not keep.is_visible():
        with suppress(TimeoutError):
            page.get_by_role("button", name="End the game here").click(timeout=1_000)
    keep.click()
    return kept_as(page)


def kept_as(page: Page) -> int:
    """Return the recording that the ended game was kept as."""
    said = page.get_by_text(re.compile(r"Kept as recording \d+"))
    number = int(re.sub(r"\D", "", said.inner_text()))
    behaviour = page.url.partition("/behaviours/")[2].partition("/")[0]
    path = f"/api/behaviours/{behaviour}/recordings"
    rows = page.evaluate("async (path) => (await fetch(path)).json()", path)
    return next(int(row["id"]) for row in rows if row["number"] == number)


def name_of(server: LiveServer, recording: int) -> str:
    """Return what the page calls a recording."""
    return f"Recording {server.http.get(f'/api/recordings/{recording}').json()['number']}"


def course_of(server: LiveServer, recording: int) -> list[Action]:
    """Return what was done in every frame of a recording."""
    return [
        Action(a) for a in server.http.get(f"/api/recordings/{recording}/course").json()["actions"]
    ]
