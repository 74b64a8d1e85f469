"""A game in a real browser: how late it is seen, slow motion, single frames, and running back."""

from __future__ import annotations

import re
from collections.abc import Iterator

import pytest
from playwright.sync_api import Browser, Page, expect

from tests.e2e.pages import DESKTOP
from tests.e2e.playing import expect_running, play_page
from testsupport.live import LiveServer
from testsupport.page_actions import end_and_keep
from tril.games.space_invaders.memory import Action

LEFT_OF_TWENTY = re.compile(r"(\d+\.\d) s")


@pytest.fixture
def page(browser: Browser, built: LiveServer) -> Iterator[Page]:
    """Return the play page of column 1 with a game begun."""
    with play_page(browser, built, viewport=DESKTOP) as page:
        page.get_by_role("button", name="Start game").click()
        expect_running(page)
        yield page


def seconds_left(page: Page) -> float:
    """Return what the clock shows."""
    found = LEFT_OF_TWENTY.search(page.get_by_role("timer", name="Time left").inner_text())
    assert found is not None
    return float(found[1])


def steps_played(page: Page) -> int:
    """Return how many steps of four frames the page says were played."""
    return int(page.get_by_text(re.compile(r"step \d+ of 300")).inner_text().split()[1])


def test_how_late_keys_are_seen_is_shown_and_kept(page: Page, built: LiveServer) -> None:
    page.keyboard.press("l")
    for key in ("ArrowRight", "ArrowLeft", "Space") * 4:
        page.keyboard.press(key, delay=120)
    latency = page.get_by_label("Latency", exact=True)
    expect(latency).to_contain_text(re.compile(r"p50\s*\d+ ms"))
    kept = built.http.get(f"/api/recordings/{end_and_keep(page)}").json()
    assert kept["latency"]["presses"] >= 10
    assert 0 < kept["latency"]["p50_ms"] < 1000


def test_a_game_is_run_back_by_key_and_both_ways_are_offered_as_a_pair(page: Page) -> None:
    page.keyboard.down("Space")
    page.wait_for_timeout(2500)
    page.keyboard.up("Space")
    before = seconds_left(page)
    page.keyboard.down("Backspace")
    expect(page.get_by_text("Rewinding.")).to_be_visible()
    page.wait_for_timeout(400)
    page.keyboard.up("Backspace")
    expect(page.get_by_text("Rewinding.")).to_be_hidden()
    assert seconds_left(page) > before
    page.keyboard.press("-")
    expect(page.get_by_role("button", name="75%")).to_have_attribute("aria-pressed", "true")
    page.wait_for_timeout(500)
    page.keyboard.press(".")
    expect(page.get_by_text("Paused", exact=True)).to_be_visible()
    standing = steps_played(page)
    for _ in range(12):
        page.keyboard.press(".")
    expect(page.get_by_text("Frame by frame:")).to_be_visible()
    expect(page.get_by_text(f"step {standing + 3} of 300")).to_be_visible()
    end_and_keep(page)
    page.get_by_role("navigation", name="Path").get_by_role("link", name="Rank").click()
    pair = page.get_by_role("region", name="Pairs to compare")
    expect(pair).to_contain_text("branches off")
    pair.get_by_role("button", name="is better").first.click()
    expect(pair).to_be_hidden()


def test_a_gamepad_steers_and_pauses(page: Page, built: LiveServer) -> None:
    page.evaluate(
        """() => {
            const up = { pressed: false }, down = { pressed: true };
            window.hold = (x, pressed) => {
                const buttons = Array.from({ length: 17 }, (_, n) => pressed === n ? down : up);
                const pad = { id: "Pad", index: 1, connected: true, mapping: "standard" };
                navigator.getGamepads = () => [null, { ...pad, axes: [x, 0], buttons }];
            };
            window.hold(0, null);
        }"""
    )
    # The page has to have seen the stick at rest.
    page.wait_for_timeout(100)
    page.evaluate("window.hold(0.9, 0)")
    page.wait_for_timeout(400)
    page.evaluate("window.hold(0, 9)")
    expect(page.get_by_text("Paused", exact=True)).to_be_visible()
    course = built.http.get(f"/api/recordings/{end_and_keep(page)}/course").json()
    assert course["actions"].count(Action.RIGHTFIRE) > 10


def test_the_stage_fills_the_screen_and_comes_back(page: Page) -> None:
    stage = page.get_by_role("application")
    width = "stage => stage.clientWidth"
    before = stage.evaluate(width)
    page.keyboard.press("f")
    page.wait_for_function("document.fullscreenElement !== null")
    assert stage.evaluate(width) > before
    page.keyboard.press("f")
    page.wait_for_function("document.fullscreenElement === null")
    assert stage.evaluate(width) == before


INK = """(label) => {
    const canvases = [...document.querySelectorAll('[role=application] > canvas')];
    const canvas = canvases[label === 'game' ? 0 : 1];
    const { width, height } = canvas;
    const { data } = canvas.getContext('2d').getImageData(0, 0, width, height);
    // Of the game the aliens, by their colour, and below the score; of the marks what is drawn.
    const isInk = label === 'game'
        ? (at) => data[at] === 134 && data[at + 1] === 134 && data[at + 2] === 29
        : (at) => data[at + 3] > 0;
    let [left, top, right, bottom] = [width, height, -1, -1];
    for (let y = 25; y < height; y += 1) for (let x = 0; x < width; x += 1) {
        if (!isInk(4 * (y * width + x))) continue;
        left = Math.min(left, x); right = Math.max(right, x);
        top = Math.min(top, y); bottom = Math.max(bottom, y);
    }
    return [left, top, right, bottom];
}"""
"""The box of what is drawn, in the game's pixels: left, top, right, bottom."""


def test_the_targets_are_outlined_where_they_stand_and_nothing_of_it_is_recorded(
    page: Page, built: LiveServer
) -> None:
    page.keyboard.press("t")
    expect(page.get_by_role("list", name="Drawn over the game")).to_contain_text(
        "remaining targets"
    )
    boxes = []
    for _ in range(2):
        page.wait_for_timeout(1500)
        page.keyboard.press("Escape")
        expect(page.get_by_text("Paused", exact=True)).to_be_visible()
        left, top, _, bottom = page.evaluate(INK, "game")
        boxes.append(page.evaluate(INK, "marks"))
        # Column 1: its six aliens of 8 by 10, each framed a pixel away.
        assert boxes[-1] == [left - 2, top - 2, left + 9, bottom + 2]
        page.keyboard.press("Enter")
        expect(page.get_by_text("Paused", exact=True)).to_be_hidden()
        expect_running(page)
    assert boxes[0] != boxes[1], "they have moved"
    kept = built.http.get(f"/api/recordings/{end_and_keep(page)}").json()
    assert kept["verification"] == "verified"


def test_the_best_demonstrations_cannon_goes_along(page: Page) -> None:
    page.keyboard.press("ArrowRight", delay=1000)
    page.keyboard.press("g")
    legend = page.get_by_role("list", name="Drawn over the game")
    expect(legend).to_contain_text("best demonstration, Recording 1")
    # The recording never leaves the left wall.
    page.wait_for_timeout(200)
    assert page.evaluate(INK, "marks") == [34, 185, 40, 194]
    page.keyboard.press("g")
    expect(legend).to_be_hidden()
    expect(page.locator("[role=application] > canvas")).to_have_count(1)


def test_a_gamepad_starts_the_first_game_and_plays_again(
    browser: Browser, built: LiveServer
) -> None:
    with play_page(browser, built, viewport=DESKTOP) as page:
        page.evaluate(
            """() => {
                window.hold = (pressed) => {
                    const state = (n) => ({ pressed: pressed === n });
                    const buttons = Array.from({ length: 17 }, (_, n) => state(n));
                    const pad = { id: "Pad", index: 0, connected: true, mapping: "standard" };
                    navigator.getGamepads = () => [{ ...pad, axes: [0, 0], buttons }];
                };
                window.hold(null);
            }"""
        )
        # The page has to have seen the button up before it can see it go down.
        expect(page.get_by_role("button", name="Start game")).to_be_visible()
        page.wait_for_timeout(300)
        page.evaluate("window.hold(9)")
        expect_running(page)
        page.evaluate("window.hold(null)")
        page.get_by_role("button", name="End the game here").click()
        expect(page.get_by_role("button", name="Keep K")).to_be_visible()
        # Just after the end a press may still be meant for the game.
        page.wait_for_timeout(800)
        page.evaluate("window.hold(0)")
        expect(page.get_by_role("button", name="Keep K")).to_be_hidden()
        expect_running(page)
