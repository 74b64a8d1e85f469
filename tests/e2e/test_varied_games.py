"""Varied games in a real browser: added, put below the worst by one press, and undone."""

from __future__ import annotations

import re
from collections.abc import Iterator

import pytest
from playwright.sync_api import Browser, Locator, Page, ViewportSize, expect

from server.web.pages import FRONTEND
from tests.e2e.pages import signed_in
from testsupport.live import LiveServer, live_server
from testsupport.workplace import Workplace
from tril.store import behaviours, borrowed, rankings

N_VARIED = 24
N_OF_COLUMN_1 = 4
PHONE = ViewportSize(width=360, height=780)


@pytest.fixture
def built(workplace: Workplace) -> Iterator[LiveServer]:
    """Return a running server with the built pages; column 2 has two borrowed games in order."""
    with workplace.database.writing() as session:
        column_2 = behaviours.by_slug(session, "column-2").id
        borrowed.borrow(session, column_2, workplace.ranked[:2])
        rankings.save(session, column_2, 0, [[number] for number in workplace.ranked[:2]])
    with live_server(workplace.settings.data, frontend=FRONTEND) as running:
        yield running


@pytest.fixture
def page(browser: Browser, built: LiveServer) -> Iterator[Page]:
    """Return the rank page of column 2 on a phone; errors in its console fail the test."""
    with signed_in(browser, built, "/behaviours/2/rank", viewport=PHONE, has_touch=True) as page:
        yield page


def tiers_of(page: Page) -> Locator:
    """Return the tiers on the board."""
    return page.get_by_role("list", name="Tiers, best first").get_by_role("listitem")


def sizes(page: Page) -> list[int]:
    """Return how many recordings each tier holds."""
    labels = [item.get_attribute("aria-label") or "" for item in tiers_of(page).all()]
    return [int(re.findall(r", (\d+) recording", label)[0]) for label in labels]


def test_varied_games_are_sorted_by_two_taps_and_exceptions_one_by_one(page: Page) -> None:
    page.get_by_role("button", name="Add varied games").tap()
    bar = page.get_by_role("group", name="Selected recordings")
    expect(bar).to_be_visible(timeout=60_000)
    found = re.search(r"(\d+) recordings selected", bar.inner_text())
    assert found
    n_selected = int(found[1])
    assert 2 < n_selected < N_VARIED, "Those that hit a target are to be placed one by one."
    expect(page.get_by_text(f"{N_VARIED} varied games added").first).to_be_attached()
    message, below = (
        page.get_by_role("button", name="Close message").bounding_box(),
        bar.bounding_box(),
    )
    assert message
    assert below
    assert message["y"] + message["height"] <= below["y"], "the message covers the bar"
    expect(page.get_by_text("from Column 1", exact=True)).to_have_count(N_OF_COLUMN_1)
    bar.get_by_role("button", name="Put below the worst").tap()
    expect(page.get_by_text("Saved", exact=True)).to_be_visible()
    assert sizes(page) == [1, 1, n_selected]
    width = page.evaluate("document.documentElement.scrollWidth")
    assert width <= PHONE["width"], "nothing is cut off at the side"

    exceptions = tiers_of(page).last.get_by_role("checkbox")
    for place in (0, 1):
        exceptions.nth(place).tap()
    bar.get_by_role("combobox").select_option("Tier 2")
    bar.get_by_role("button", name="Put into tier 2").tap()
    expect(page.get_by_text("Saved", exact=True)).to_be_visible()
    assert sizes(page) == [1, 3, n_selected - 2]

    undo = page.get_by_role("button", name="Undo (Ctrl+Z)")
    for n_tiers in (3, 2):
        undo.tap()
        expect(tiers_of(page)).to_have_count(n_tiers)
    assert sizes(page) == [1, 1]
