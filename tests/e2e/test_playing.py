"""A game in a real browser: how late it is seen, slow motion, single frames, and running back."""

from __future__ import annotations

import re
from collections.abc import Iterator

import pytest
from playwright.sync_api import Browser, Page, expect

from server.pages import FRONTEND
from tests.server.live import LiveServer, cookie, live_server
from tests.workplace import make_workplace
from tril.game.space_invaders import Action

LEFT_OF_TWENTY = re.compile(r"(\d+\.\d) s")


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> Iterator[LiveServer]:
    """Return a running server with the built pages, and nothing else of a Tril."""
    made = make_workplace(tmp_path_factory.mktemp("playing") / "data")
    made.database.close()
    with live_server(made.settings.data, frontend=FRONTEND) as running:
        yield running


@pytest.fixture
def page(browser: Browser, built: LiveServer) -> Iterator[Page]:
    """Return the play page of column 1; errors in its console fail the test."""
    address = f"http://{built.authority}"
    context = browser.new_context(viewport={"width": 1280, "height": 900})
    name, value = cookie(built.settings).split("=", 1)
    context.add_cookies([{"name": name, "value": value, "url": address}])
    page = context.new_page()
    problems: list[str] = []
    page.on("pageerror", lambda error: problems.append(str(error)))
    page.on("console", lambda m: problems.append(m.text) if m.type == "error" else None)
    page.set_default_timeout(15_000)
    page.goto(f"{address}/behaviours/1/play")
    page.get_by_role("button", name="Start game").click()
    expect(page.get_by_role("timer", name="Time left")).not_to_contain_text("20.0 s")
    yield page
    context.close()
    assert not problems, problems


def seconds_left(page: Page) -> float:
    """Return what the clock shows."""
    found = LEFT_OF_TWENTY.search(page.get_by_role("timer", name="Time left").inner_text())
    assert found is not None
    return float(found[1])


def steps_played(page: Page) -> int:
    """Return how many steps of four frames the page says were played."""
    return int(page.get_by_text(re.compile(r"step \d+ of 300")).inner_text().split()[1])


def end_and_keep(page: Page) -> int:
    """End the game and keep it; returns its recording."""
    page.get_by_role("button", name="End the game here").click()
    page.get_by_role("button", name="Keep").click()
    said = page.get_by_text(re.compile(r"Kept as recording \d+"))
    return int(re.sub(r"\D", "", said.inner_text()))


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
    expect(page.get_by_text("Running back.")).to_be_visible()
    page.wait_for_timeout(400)
    page.keyboard.up("Backspace")
    expect(page.get_by_text("Running back.")).to_be_hidden()
    assert seconds_left(page) > before
    page.keyboard.press("-")
    expect(page.get_by_role("button", name="75 %")).to_have_attribute("aria-pressed", "true")
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
    expect(pair).to_contain_text("goes on from")
    pair.get_by_role("button", name="is better").first.click()
    expect(pair).to_be_hidden()


def test_a_gamepad_steers_and_pauses(page: Page, built: LiveServer) -> None:
    page.evaluate(
        """() => {
            const up = { pressed: false }, down = { pressed: true };
            window.hold = (x, pressed) => {
                const buttons = Array.from({ length: 17 }, (_, n) => pressed === n ? down : up);
                navigator.getGamepads = () => [null, { axes: [x, 0], buttons }];
            };
            window.hold(0.9, 0);
        }"""
    )
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
