"""Unranked games in a real browser, placed among ranked ones by comparing them."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator

import numpy as np
import pytest
from playwright.sync_api import Browser, Locator, Page, ViewportSize, expect

from server.web.pages import FRONTEND
from tests.e2e.pages import DESKTOP, signed_in
from testsupport.live import LiveServer, live_server
from testsupport.workplace import Workplace
from tril.demonstrators import play_randomly
from tril.games.space_invaders import SPACE_INVADERS
from tril.store import rankings, recordings
from tril.store.models import Source

N_UNRANKED = 3
MAX_LOOKS = 5
"""Of one game among at most seven tiers, even if an opinion leads astray."""
PHONE = ViewportSize(width=360, height=740)
IS_INSIDE = "document.activeElement.matches('body, dialog, dialog *')"
"""Whether the focus is in a dialog, or in none of the page's controls."""
SCREEN = re.compile("^Game screen of Recording")


@pytest.fixture
def unranked(workplace: Workplace) -> list[int]:
    """Add games to column 1 that are not ranked, and return them in the order of the page."""
    rng = np.random.default_rng(5)
    with workplace.database.writing() as session:
        for _ in range(N_UNRANKED):
            one = play_randomly(rng, SPACE_INVADERS.make_console())
            recordings.add(session, 1, one.recording, one.replay, Source.VARIED)
        return rankings.unranked(session, rankings.current(session, 1))


@pytest.fixture
def built(workplace: Workplace, unranked: list[int]) -> Iterator[LiveServer]:
    """Return a running server with the built pages; four games are ranked, three are not."""
    with live_server(workplace.settings.data, frontend=FRONTEND) as running:
        yield running


def compared(page: Page) -> list[int]:
    """Return the game that is to be placed and the ranked one beside it, none at the end."""
    headings = page.get_by_role("dialog").get_by_role("heading", level=3).all_inner_texts()
    return [int(heading.split()[-1]) for heading in headings]


def place(page: Page, game: int, answer: Callable[[int], None]) -> None:
    """Answer each question about a game, of which the answer is given the opponent."""
    for _ in range(MAX_LOOKS):
        match compared(page):
            case [asked, opponent] if asked == game:
                answer(opponent)
            case _:
                return
    assert game not in compared(page)[:1], f"Game {game} has no place after {MAX_LOOKS} looks"


def saved_order(workplace: Workplace) -> tuple[int, list[list[int]]]:
    """Return revision and tiers as they are in the database."""
    with workplace.database.reading() as session:
        row = rankings.current(session, 1)
        return row.revision, [list(tier) for tier in row.tiers]


def expect_saved(page: Page) -> None:
    """Wait until the order is saved."""
    expect(page.get_by_text("Saved", exact=True)).to_be_visible()


def test_three_games_are_placed_by_keyboard_and_by_mouse(
    browser: Browser, built: LiveServer, workplace: Workplace, unranked: list[int]
) -> None:
    best, second, third, worst = workplace.ranked
    one, other, last = unranked
    revision, _ = saved_order(workplace)
    with signed_in(browser, built, "/behaviours/1/rank", viewport=DESKTOP) as page:
        tray = page.get_by_role("region", name=re.compile("Unranked"))
        tray.get_by_role("button", name="Place by comparing").focus()
        page.keyboard.press("Enter")
        dialog = page.get_by_role("dialog", name="Which is better?")
        expect(dialog.get_by_role("img", name=SCREEN)).to_have_count(2)
        expect(dialog.get_by_text(re.compile(f"^Game 1 of {N_UNRANKED}, about"))).to_be_visible()
        for _ in range(20):
            page.keyboard.press("Tab")
            assert page.evaluate(IS_INSIDE), "the page behind can't be reached"

        place(page, one, lambda _opponent: page.keyboard.press("ArrowLeft"))
        assert compared(page)[0] == other
        sides = ("Left", "Right")
        button = {side: dialog.get_by_role("button", name=f"{side} is better") for side in sides}
        place(
            page,
            other,
            lambda opponent: (
                dialog.get_by_role("button", name="Equally good").click()
                if opponent == third
                else button["Left" if opponent == worst else "Right"].click()
            ),
        )
        page.keyboard.press("w")
        page.get_by_role("button", name="Undo the last answer").click()
        expect(dialog.get_by_text(re.compile(f"^Game 3 of {N_UNRANKED}"))).to_be_visible()
        place(
            page,
            last,
            lambda opponent: page.keyboard.press(
                "ArrowRight" if opponent in (one, best) else "ArrowLeft"
            ),
        )
        expect(page.get_by_text(f"{N_UNRANKED} recordings have their place.")).to_be_visible()
        page.keyboard.press("Enter")
        expect(page.get_by_role("heading", name="Unranked (0)")).to_be_focused()
        expect_saved(page)
        order = [[one], [best], [last], [second], [third, other], [worst]]
        # One revision each; the undo of the last one and its place are two more.
        assert saved_order(workplace) == (revision + 5, order)

        page.get_by_role("button", name="Undo (Ctrl+Z)").click()
        expect(page.get_by_role("heading", name="Unranked (1)")).to_be_visible()


def test_games_are_compared_one_above_the_other_on_a_phone(
    browser: Browser, built: LiveServer, workplace: Workplace, unranked: list[int]
) -> None:
    options = {"viewport": PHONE, "has_touch": True, "reduced_motion": "reduce"}
    with signed_in(browser, built, "/behaviours/1/rank?compare", **options) as page:
        dialog = page.get_by_role("dialog", name="Which is better?")
        expect(dialog.get_by_role("img", name=SCREEN)).to_have_count(2)
        expect(dialog.get_by_role("button", name="Play", exact=True)).to_be_visible()
        upper, lower = (box_of(dialog.get_by_role("img", name=SCREEN).nth(at)) for at in (0, 1))
        assert upper[1] + upper[3] <= lower[1], "one is above the other"
        for _, _, width, height in (upper, lower):
            assert width % 160 == 0, "whole pixels"
            assert height % 210 == 0, "whole pixels"
        assert dialog.evaluate("it => it.scrollWidth <= it.clientWidth"), "nothing is cut off"

        dialog.get_by_role("button", name="Skip").tap()
        dialog.get_by_role("button", name="All 2 left below the worst").tap()
        expect(page.get_by_text("1 was skipped and stays unranked.")).to_be_visible()
        page.get_by_role("button", name="Back to the ranking").tap()
        expect_saved(page)
        _, tiers = saved_order(workplace)
        assert tiers == [*([key] for key in workplace.ranked), unranked[1:]]
        assert page.url.endswith("/rank")


def box_of(element: Locator) -> tuple[float, float, float, float]:
    """Return where an element is, as left, top, width and height."""
    box = element.bounding_box()
    assert box is not None
    return box["x"], box["y"], box["width"], box["height"]
