"""A game that has no module of its own, from the page of games to its replay."""

from __future__ import annotations

import re

from playwright.sync_api import Browser, Page, expect

from tests.e2e.pages import DESKTOP, signed_in
from tests.e2e.playing import name_of
from testsupport.live import LiveServer
from testsupport.page_actions import end_and_keep
from tril.games import game_named

PONG = game_named("pong")


def actions_of(server: LiveServer, recording: int) -> set[str]:
    """Return the names of the actions of a recording."""
    course = server.http.get(f"/api/recordings/{recording}/course").json()
    return {PONG.controls.actions[action] for action in course["actions"]}


def create_behaviour(page: Page) -> None:
    """Find Pong on the page of games, and create a behaviour of ten seconds in it."""
    page.get_by_role("searchbox", name="Find a game").fill("pong")
    card = page.get_by_role("link", name="Pong", exact=True)
    picture = card.locator("img")
    expect(picture).to_have_js_property("naturalHeight", PONG.screen.height)
    card.click()
    page.get_by_role("button", name="Teach a behaviour").click()
    dialog = page.get_by_role("dialog", name="Teach a behaviour in Pong")
    dialog.get_by_label("Description").fill("Keep level with the ball.")
    dialog.get_by_label("Name").fill("Keep level")
    dialog.get_by_text("How it is played").click()
    seconds = dialog.get_by_label("Longest game, in seconds")
    seconds.press_sequentially("1")
    seconds.press("Backspace")
    # What was unfolded stays so.
    seconds.press_sequentially("10")
    dialog.get_by_role("button", name="Create behaviour").click()
    page.wait_for_url("**/play")


def test_a_game_is_found_taught_played_kept_and_replayed(
    browser: Browser, built: LiveServer
) -> None:
    with signed_in(browser, built, "/games", viewport=DESKTOP) as page:
        create_behaviour(page)
        expect(page.get_by_role("link", name="Pong")).to_be_visible()
        expect(page.get_by_role("timer", name="Time left")).to_contain_text("10.0 s")
        page.get_by_role("button", name="Start game").click()
        expect(page.get_by_role("button", name="Pause")).to_be_visible()
        expect(page.locator("strong[role=timer]")).to_be_hidden(timeout=15_000)
        for key in ("ArrowUp", "ArrowDown", "Space"):
            page.keyboard.down(key)
            before = page.get_by_text(re.compile(r"^step \d+ of 150$")).inner_text()
            expect(page.get_by_text(before, exact=True)).to_be_hidden()
            page.wait_for_timeout(400)
            page.keyboard.up(key)
        recording = end_and_keep(page)
        assert {"RIGHT", "LEFT", "FIRE"} <= actions_of(built, recording)
        page.get_by_role("link", name=re.compile("Recordings")).click()
        card = page.get_by_role("article", name=name_of(built, recording))
        expect(card).to_contain_text("Score")
        expect(card).to_contain_text("ended early")
        card.get_by_role("link", name=name_of(built, recording)).click()
        slider = page.get_by_role("slider", name="Position in the recording")
        slider.press("End")
        last = built.http.get(f"/api/recordings/{recording}").json()["n_frames"]
        expect(slider).to_have_value(str(last))
        canvas = page.get_by_role("img", name="Game screen")
        size = canvas.evaluate("(canvas) => [canvas.height, canvas.width]")
        assert tuple(size) == PONG.screen.shape
        expect(page.get_by_role("img", name=re.compile("^Keys held over time"))).to_be_visible()
        page.goto("/games")
        first = page.get_by_role("listitem").first
        expect(first).to_contain_text("Pong")
        expect(first).to_contain_text("1 behaviour")


def test_a_game_of_many_items_fits_beside_its_picture(browser: Browser, built: LiveServer) -> None:
    corner = {"name": "Corner", "description": "Take the first brick.", "target": [[0, 0]]}
    new = {"game": "breakout", **corner}
    made = built.http.post("/api/behaviours", json=new).raise_for_status().json()
    with signed_in(browser, built, f"/behaviours/{made['id']}/play", viewport=DESKTOP) as page:
        grid = page.get_by_role("img", name=re.compile("of 1 target hit"))
        expect(grid).to_be_visible()
        box = grid.bounding_box()
        assert box is not None
        assert box["x"] + box["width"] <= DESKTOP["width"]
        overflow = "document.documentElement.scrollWidth - document.documentElement.clientWidth"
        assert page.evaluate(overflow) <= 0
        button = page.get_by_role("button", name="Change the keys").bounding_box()
        assert button is not None
        assert button["x"] + button["width"] <= DESKTOP["width"]
