"""What a person does on the pages, by the names that stand there."""

from __future__ import annotations

import re
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass

import numpy as np
from playwright.sync_api import Locator, Page, TimeoutError, expect

COUNTDOWN_TIMEOUT_MS = 15_000
DRAG_TIMEOUT_S = 20
HOLD_S = (0.2, 0.6)
"""How long a key is held, at least and at most."""
RUN_ENDED = re.compile("^(Done|Failed|Stopped|Cancelled)$")


@dataclass(frozen=True)
class Steering:
    """How a game is steered by keys.

    Attributes:
        keys: Keys of which one after the other is held, chosen at random; "" holds none.
        others: Keys that are held the rest of the time.
        share: For how much of the game keys of the first kind are held, 0 to 1.
    """

    keys: Sequence[str]
    others: Sequence[str]
    share: float


class Visitor:
    """Somebody at a page, who clicks what has a name, presses keys and plays.

    Attributes:
        page: The page.
        clicks: Number of clicks and drags so far.
        keys: Number of key presses so far, without those that steer a game.
        played_s: Seconds of playing so far, from the start of a game to its end.
        waited_s: Seconds that Tril worked so far and the visitor waited.
    """

    def __init__(self, page: Page, rng: np.random.Generator | None = None) -> None:
        self.page = page
        self.clicks = self.keys = 0
        self.played_s = self.waited_s = 0.0
        self._rng = rng or np.random.default_rng(0)

    def click(self, target: Locator) -> None:
        """Click something."""
        target.click()
        self.clicks += 1

    def press(self, key: str) -> None:
        """Press a key."""
        self.page.keyboard.press(key, delay=50)
        self.keys += 1

    def write(self, field: Locator, text: str) -> None:
        """Click a field and write a text in place of what it has."""
        field.click()
        field.fill(text)
        self.clicks += 1
        self.keys += len(text)

    def follow(self, name: str | re.Pattern[str]) -> None:
        """Click the first link of a name."""
        self.click(self.page.get_by_role("link", name=name).first)

    def step(self, name: str) -> None:
        """Click a step of a behaviour's path."""
        path = self.page.get_by_role("navigation", name="Path")
        self.click(path.get_by_role("link", name=name))

    def wait_for(self, target: Locator, timeout_ms: float) -> None:
        """Wait for what Tril works on."""
        began = time.monotonic()
        try:
            expect(target).to_be_visible(timeout=timeout_ms)
        finally:
            self.waited_s += time.monotonic() - began

    def play(
        self, steering: Steering, limit_s: float, midway: Callable[[], None] | None = None
    ) -> int:
        """Play a game to its end and keep it; returns its recording's number.

        Args:
            steering: What is held.
            limit_s: After how long it is ended, if it still goes.
            midway: Called once, after a sixth of that time.
        """
        start = self.page.get_by_role("button", name=re.compile("^(Start game|Play again)"))
        self.click(start)
        began = time.monotonic()
        expect(self.page.get_by_role("button", name="Pause")).to_be_visible()
        countdown = self.page.locator("strong[role=timer]")
        expect(countdown).to_be_hidden(timeout=COUNTDOWN_TIMEOUT_MS)
        running = time.monotonic()
        keep = self.page.get_by_role("button", name="Keep K")
        while not keep.is_visible() and time.monotonic() - running < limit_s:
            held = steering.keys if self._rng.random() < steering.share else steering.others
            self.hold(held[int(self._rng.integers(len(held)))], self._rng.uniform(*HOLD_S))
            if midway and time.monotonic() - running > limit_s / 6:
                midway()
                midway = None
        self.played_s += time.monotonic() - began
        self.clicks += 1
        end_and_keep(self.page)
        return kept_number(self.page)

    def hold(self, key: str, held_s: float) -> None:
        """Hold a key of the game, "" for none."""
        if key:
            self.page.keyboard.down(key)
        self.page.wait_for_timeout(1000 * held_s)
        if key:
            self.page.keyboard.up(key)

    def rank(self, recordings: Sequence[int]) -> None:
        """Put unranked games on the board by their buttons.

        Args:
            recordings: Best first.
        """
        # A list shows what is in sight alone, so each becomes the best in turn.
        for recording in reversed(recordings):
            name = re.compile(rf"^Rank as best: .*\b{recording}$")
            self.click(self.page.get_by_role("button", name=name))
        self.expect_saved()

    def expect_saved(self) -> None:
        """Wait until the order is saved."""
        expect(self.page.get_by_role("status").get_by_text("Saved")).to_be_visible()

    def wait_for_understanding(self, timeout_ms: float) -> Locator:
        """Wait until the rank page says what Tril understood; returns that region."""
        understood = self.page.get_by_role("region", name="What Tril understood")
        self.wait_for(understood.get_by_role("listitem").first, timeout_ms)
        return understood

    def start_training(self, steps: int) -> None:
        """Start a run of so many steps on the page of training."""
        self.write(self.page.get_by_label("Steps", exact=True), str(steps))
        self.click(self.page.get_by_role("button", name="Train", exact=True))
        self.page.wait_for_url(re.compile("/runs/"))

    def wait_for_run(self, timeout_ms: float) -> str:
        """Wait until the run that is shown has ended; returns its status."""
        ended = self.page.get_by_text(RUN_ENDED).first
        self.wait_for(ended, timeout_ms)
        return ended.inner_text()


def end_and_keep(page: Page) -> int:
    """End the game, unless a bomb was quicker, and keep it; returns its recording's id."""
    keep = page.get_by_role("button", name="Keep K")
    while not keep.is_visible():
        with suppress(TimeoutError):
            page.get_by_role("button", name="End the game here").click(timeout=1_000)
    keep.click()
    return kept_as(page)


def kept_as(page: Page) -> int:
    """Return the id of the recording that the ended game was kept as."""
    number = kept_number(page)
    behaviour = page.url.partition("/behaviours/")[2].partition("/")[0]
    path = f"/api/behaviours/{behaviour}/recordings"
    rows = page.evaluate("async (path) => (await fetch(path)).json()", path)
    return next(int(row["id"]) for row in rows if row["number"] == number)


def kept_number(page: Page) -> int:
    """Return the number that the page calls the recording that the ended game was kept as."""
    said = page.get_by_text(re.compile(r"Kept as recording \d+"))
    return int(re.sub(r"\D", "", said.inner_text()))


def handle_of(where: Locator, recording: int) -> Locator:
    """Return the handle that a game of the rank page is dragged by."""
    return where.get_by_role("button", name=f"Move Recording {recording}", exact=True)


def drag_into(page: Page, handle: Locator, target: Locator, announced: str) -> None:
    """Drag as a person does: after the place while the page scrolls, until it stays lit.

    Args:
        page: The rank page.
        handle: Of a game.
        target: The place.
        announced: What the page calls the place.
    """
    handle.scroll_into_view_if_needed()
    start = handle.bounding_box()
    assert start is not None
    page.mouse.move(start["x"] + start["width"] / 2, start["y"] + start["height"] / 2)
    page.mouse.down()
    page.mouse.move(start["x"] - 20, start["y"] - 20, steps=4)
    lit = page.get_by_text(f"Over {announced}")
    deadline = time.monotonic() + DRAG_TIMEOUT_S
    aimed_at = None
    while not (lit.count() and target.bounding_box() == aimed_at):
        assert time.monotonic() < deadline, f"the page does not say: Over {announced}"
        aimed_at = target.bounding_box()
        assert aimed_at is not None
        x, y = aimed_at["x"] + aimed_at["width"] / 2, aimed_at["y"] + aimed_at["height"] / 2
        page.mouse.move(x, y, steps=12)
        page.wait_for_timeout(100)
    page.mouse.up()
