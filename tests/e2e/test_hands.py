"""Played and ranked with a finger or two on a phone, and with one hand on the keyboard."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest
from playwright.sync_api import Browser, CDPSession, Locator, Page, expect

from tests.e2e.pages import DESKTOP
from tests.e2e.playing import course_of, expect_running, name_of, play_page
from testsupport.live import LiveServer
from testsupport.page_actions import kept_as
from tril.games.space_invaders.memory import Action

PHONE: dict[str, Any] = {
    "viewport": {"width": 360, "height": 740},
    "device_scale_factor": 3,
    "has_touch": True,
    "is_mobile": True,
}
MOST_TABS = 80
MOST_GAMES = 6
HOLD_MS = 340


class Fingers:
    """Fingers on the page: put down and lifted one by one, as the browser emulates them."""

    def __init__(self, page: Page) -> None:
        self._session: CDPSession = page.context.new_cdp_session(page)
        self._down: dict[int, dict[str, float]] = {}

    def put(self, finger: int, button: Locator) -> None:
        """Put a finger down on the middle of a button."""
        box = button.bounding_box()
        assert box is not None
        x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
        self._down[finger] = {"x": x, "y": y, "id": finger}
        self._send("touchStart", self._down[finger])

    def slide(self, finger: int, dx: float, dy: float) -> None:
        """Move a finger that lies on the screen."""
        point = self._down[finger]
        self._down[finger] = {**point, "x": point["x"] + dx, "y": point["y"] + dy}
        self._send("touchMove", self._down[finger])

    def lift(self, finger: int) -> None:
        """Take a finger off the screen."""
        self._send("touchEnd", self._down.pop(finger))

    def _send(self, kind: str, changed: dict[str, float]) -> None:
        self._session.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": [changed]})


@pytest.fixture
def phone(browser: Browser, built: LiveServer) -> Iterator[Page]:
    """Return the play page of column 1 on a phone."""
    with play_page(browser, built, **PHONE) as page:
        yield page


def steer(phone: Page) -> bool:
    """Play by touch for under two seconds; returns whether the game still goes on after that.

    Every start for play survives this if nothing is held for much longer; who stays on the right
    for another second is hit by a bomb in most games.
    """
    pad = phone.get_by_role("group", name="Touch controls")
    right, left, fire = (pad.get_by_role("button", name=name) for name in ("Right", "Left", "Fire"))
    fingers = Fingers(phone)
    fingers.put(1, right)
    phone.wait_for_timeout(HOLD_MS)
    fingers.put(2, fire)
    phone.wait_for_timeout(HOLD_MS)
    fingers.lift(2)
    fingers.lift(1)
    fingers.put(1, left)
    phone.wait_for_timeout(HOLD_MS)
    fingers.lift(1)
    fingers.put(2, fire)
    phone.wait_for_timeout(HOLD_MS // 2)
    # A finger that slides off its button still holds it, until it is lifted.
    fingers.slide(2, 0, 150)
    phone.wait_for_timeout(HOLD_MS // 2)
    fingers.lift(2)
    # A bomb may have ended it, which the page learns once the game has been checked.
    timer = phone.get_by_role("timer", name="Time left")
    before = timer.inner_text()
    phone.wait_for_timeout(300)
    still_shown = phone.get_by_role("button", name="End the game here").is_visible()
    return still_shown and timer.inner_text() != before


def test_a_game_is_played_and_ranked_by_touch(phone: Page, built: LiveServer) -> None:
    phone.get_by_role("button", name="Start game").tap()
    for _ in range(MOST_GAMES):
        expect_running(phone)
        if steer(phone):
            break
        phone.get_by_role("button", name="Play again").tap()
    else:
        pytest.fail(f"All {MOST_GAMES} games were lost.")
    assert phone.evaluate("document.documentElement.scrollWidth") == 360
    assert phone.evaluate("window.getSelection().toString()") == ""

    phone.get_by_role("button", name="End the game here").tap()
    phone.get_by_role("button", name="Keep", exact=True).tap()
    recording = kept_as(phone)
    course = course_of(built, recording)
    order = [Action.RIGHT, Action.RIGHTFIRE, Action.LEFT, Action.FIRE]
    assert [action for action in dict.fromkeys(course) if action] == order
    assert all(course.count(action) > 15 for action in order)
    assert built.http.get(f"/api/recordings/{recording}").json()["verification"] == "verified"

    phone.get_by_role("navigation", name="Path").get_by_role("link", name="Rank").tap()
    name = name_of(built, recording)
    phone.get_by_role("button", name=f"Rank as best: {name}").tap()
    expect_best(phone, name)
    phone.get_by_role("button", name=f"Down: {name}").tap()
    expect(phone.get_by_role("listitem", name="Tier 2 of").get_by_role("heading")).to_have_text(
        name
    )
    expect(phone.get_by_text("Saved")).to_be_visible()


def test_a_game_is_played_and_ranked_with_one_hand_on_the_keyboard(
    browser: Browser, built: LiveServer
) -> None:
    with play_page(browser, built, viewport=DESKTOP) as page:
        # The right hand alone: arrows, enter and tab.
        tab_to(page, page.get_by_role("button", name="Start game"))
        page.keyboard.press("Enter")
        expect_running(page)
        page.keyboard.down("ArrowRight")
        page.keyboard.down("ArrowUp")
        page.wait_for_timeout(600)
        page.keyboard.up("ArrowRight")
        page.keyboard.up("ArrowUp")
        tab_to(page, page.get_by_role("button", name="End the game here"))
        page.keyboard.press("Enter")
        expect(page.get_by_role("button", name="Keep K")).to_be_visible()
        page.wait_for_timeout(800)
        page.keyboard.press("Enter")
        recording = kept_as(page)
        assert course_of(built, recording).count(Action.RIGHTFIRE) > 15

        tab_to(page, page.get_by_role("navigation", name="Path").get_by_role("link", name="Rank"))
        page.keyboard.press("Enter")
        name = name_of(built, recording)
        tab_to(page, page.get_by_role("button", name=f"Rank as best: {name}"))
        page.keyboard.press("Enter")
        expect_best(page, name)
        expect(page.get_by_text("Saved")).to_be_visible()


def expect_best(page: Page, name: str) -> None:
    """Expect a recording alone in the best tier."""
    best = page.get_by_role("listitem", name="Tier 1 of")
    expect(best.get_by_role("heading")).to_have_text(name)


def tab_to(page: Page, wanted: Locator) -> None:
    """Press tab until something has the focus."""
    expect(wanted).to_be_visible()
    for _ in range(MOST_TABS):
        if wanted.evaluate("element => element === document.activeElement"):
            return
        page.keyboard.press("Tab")
    raise AssertionError(f"{wanted} is not reached by keyboard.")
