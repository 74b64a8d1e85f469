"""What the tests that play in a real browser share."""

from __future__ import annotations

from contextlib import AbstractContextManager
from typing import Any

from playwright.sync_api import Browser, Page, expect

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


def name_of(server: LiveServer, recording: int) -> str:
    """Return what the page calls a recording."""
    return f"Recording {server.http.get(f'/api/recordings/{recording}').json()['number']}"


def course_of(server: LiveServer, recording: int) -> list[Action]:
    """Return what was done in every frame of a recording."""
    return [
        Action(a) for a in server.http.get(f"/api/recordings/{recording}/course").json()["actions"]
    ]
