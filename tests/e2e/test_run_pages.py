"""The pages of runs in a real browser: sizes on every screen, charts by mouse and keyboard."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest
from playwright.sync_api import Browser, Page, ViewportSize, expect

from server.web.pages import FRONTEND
from tests.e2e.pages import DESKTOP, WITHOUT_INFERENCE, signed_in
from tests.server.api.test_runs import fill_with_results
from testsupport.live import LiveServer, live_server
from testsupport.workplace import Workplace
from tril.store.training import metrics, runs

LONG_NAME = "A network that is twice as wide, with another learning rate and more steps"
SMALL_TARGETS = """() => {
  const least = matchMedia("(pointer: coarse)").matches ? 44 : 24;
  return [...document.querySelectorAll("button, select, summary, input, a")]
    .filter((one) => one.checkVisibility() && getComputedStyle(one).display !== "inline")
    .map((one) => one.closest("label") ?? one)
    .filter((one) => one.offsetHeight < least && getComputedStyle(one).position !== "absolute")
    .map((one) => one.textContent.slice(0, 30));
}"""
"""The controls that are too low for a finger, or a mouse; links in text may be."""


@pytest.fixture(scope="module")
def compared(shared_workplace: Workplace) -> tuple[str, ...]:
    """Return two finished runs with curves, one with a long name."""
    made = tuple(fill_with_results(shared_workplace) for _ in range(2))
    with shared_workplace.database.writing() as session:
        runs.describe(session, made[0], LONG_NAME, "Does it help?")
        for run_id in made:
            for step in range(1, 200):
                metrics.add(session, run_id, "imitator", step * 1000, {"entropy": 2 - step / 200})
    return made


@pytest.fixture(scope="module")
def built(shared_workplace: Workplace) -> Iterator[LiveServer]:
    """Return a running server with the built pages."""
    with live_server(shared_workplace.settings.data, frontend=FRONTEND) as running:
        yield running


def pages_of(made: tuple[str, ...]) -> dict[str, str]:
    comparison = "&".join(f"run={run_id}" for run_id in made)
    return {
        "/": "New behaviour",
        "/behaviours/1/runs": "New run",
        "/behaviours/1/train": "Train",
        f"/runs/{made[0]}#curves": "Download the curves (CSV)",
        f"/runs/compare?{comparison}": "Download the curves (CSV)",
    }


@pytest.mark.parametrize("width", [320, 360])
def test_pages_fit_a_phone_and_a_finger(
    browser: Browser, built: LiveServer, compared: tuple[str, ...], width: int
) -> None:
    size = ViewportSize(width=width, height=640)
    touch: dict[str, Any] = {"viewport": size, "has_touch": True, "is_mobile": True}
    with signed_in(browser, built, "/", WITHOUT_INFERENCE, **touch) as page:
        for path, control in pages_of(compared).items():
            page.goto(path)
            expect(page.get_by_text(control, exact=True).first).to_be_visible()
            assert page.evaluate("document.documentElement.scrollWidth") == width, path
            assert page.evaluate(SMALL_TARGETS) == [], path


def test_pages_use_a_wide_screen(
    browser: Browser, built: LiveServer, compared: tuple[str, ...]
) -> None:
    wide = ViewportSize(width=2560, height=1300)
    with signed_in(browser, built, "/behaviours/1/runs", viewport=wide) as page:
        table = page.get_by_role("table", name="Runs")
        expect(table).to_be_visible()
        assert table.evaluate("(one) => one.offsetWidth") > 1500
        assert page.evaluate(SMALL_TARGETS) == []


def test_a_chart_is_zoomed_and_read_by_mouse_and_keyboard(
    browser: Browser, built: LiveServer, compared: tuple[str, ...]
) -> None:
    path = f"/runs/compare?run={compared[0]}&run={compared[1]}"
    with signed_in(browser, built, path, viewport=DESKTOP) as page:
        chart = page.get_by_role("slider", name="Indecision (entropy): cursor")
        expect(chart).to_have_attribute("aria-valuenow", "199000")
        drag_over(page)
        zoomed = page.get_by_role("button", name="Zoom out")
        expect(zoomed).to_be_visible()
        chart.press("Home")
        first = int(chart.get_attribute("aria-valuenow") or 0)
        assert 1000 < first < 199_000
        chart.press("ArrowRight")
        expect(chart).to_have_attribute("aria-valuenow", str(first + 1000))
        chart.press("0")
        expect(zoomed).to_have_count(0)
        chart.press("Home")
        expect(chart).to_have_attribute("aria-valuenow", "1000")
        chart.press("+")
        expect(zoomed).to_be_visible()
        page.keyboard.press("?")
        expect(page.get_by_role("dialog", name="Keys on this page")).to_be_visible()


def drag_over(page: Page) -> None:
    """Select the second quarter of the chart."""
    chart = page.get_by_role("slider", name="Indecision (entropy): cursor")
    chart.scroll_into_view_if_needed()
    box = chart.bounding_box()
    assert box is not None
    y = box["y"] + box["height"] / 2
    page.mouse.move(box["x"] + box["width"] / 4, y)
    page.mouse.down()
    page.mouse.move(box["x"] + box["width"] / 2, y, steps=4)
    page.mouse.up()
