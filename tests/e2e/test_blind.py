"""A blind comparison in a real browser: judged by keys and mouse, left, taken back, and told."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from playwright.sync_api import Browser, Locator, Page, expect

from server.web.pages import FRONTEND
from tests.e2e.pages import DESKTOP, WITHOUT_INFERENCE, signed_in
from testsupport.finished_runs import add_greedy_games, make_finished_run
from testsupport.live import LiveServer, live_server
from testsupport.workplace import Workplace
from tril.store.training import blind_answers, runs

N_PAIRS = 4
"""Two starts with both policies' games, two demonstrations in the upper half."""
NAMES = ("Imitator", "Clone", "Demonstrator", "Recording", "targets", "steps")
"""Words that would tell whose a game is."""


@pytest.fixture
def run_id(workplace: Workplace) -> str:
    """Make a finished run with greedy games from two starts."""
    made = make_finished_run(workplace)
    add_greedy_games(workplace, made, [3])
    return made


@pytest.fixture
def built(workplace: Workplace, run_id: str) -> Iterator[LiveServer]:
    """Return a running server with the built pages."""
    with live_server(workplace.settings.data, frontend=FRONTEND) as running:
        yield running


def judge(page: Page, number: int, press: str | Locator) -> None:
    """Judge a pair, by a key or a button, once its games are there."""
    dialog = page.get_by_role("dialog", name="Which is closer to what you meant?")
    expect(dialog.get_by_text(f"Pair {number} of {N_PAIRS}")).to_be_visible()
    for side in ("left", "right"):
        expect(dialog.get_by_label(f"Game screen of the {side} game")).to_be_visible()
    shown = dialog.inner_html()
    assert not [name for name in NAMES if name in shown]
    if isinstance(press, str):
        page.keyboard.press(press)
    else:
        press.click()


def test_a_person_judges_pairs_without_knowing_whose_they_are(
    browser: Browser, built: LiveServer, workplace: Workplace, run_id: str
) -> None:
    with workplace.database.reading() as session:
        pairs = blind_answers.pairs_of(session, runs.get(session, run_id), 1)
    assert len(pairs) == N_PAIRS
    with signed_in(browser, built, f"/runs/{run_id}", WITHOUT_INFERENCE, viewport=DESKTOP) as page:
        page.get_by_role("button", name="Compare blind").click()
        judge(page, 1, "ArrowLeft")
        judge(page, 2, page.get_by_role("button", name="Right is closer"))
        judge(page, 3, "=")
        # What is pressed while an answer is being saved is not taken.
        expect(page.get_by_text(f"Pair 4 of {N_PAIRS}")).to_be_visible()
        page.keyboard.press("Backspace")
        expect(page.get_by_text(f"Pair 3 of {N_PAIRS}")).to_be_visible()
        page.keyboard.press("Escape")
        page.reload()
        page.get_by_role("button", name=f"Continue: 2 of {N_PAIRS} judged").click()
        judge(page, 3, "ArrowRight")
        judge(page, 4, "2")
        expect(page.get_by_text(f"All {N_PAIRS} pairs are judged.")).to_be_visible()
        page.get_by_role("button", name="Show who played which").press("Enter")

        wins = sum(pair.imitator_left for pair in pairs[:1])
        wins += sum(not pair.imitator_left for pair in pairs[1:])
        told = page.get_by_role("dialog", name="Who played which")
        expect(told.get_by_role("status")).to_contain_text(f"The imitator won {wins} of {N_PAIRS}")
        listed = told.get_by_role("list", name="Who played which").get_by_role("listitem")
        for item, pair in zip(listed.all(), pairs, strict=True):
            links = [link.get_attribute("href") for link in item.get_by_role("link").all()]
            assert links == [f"/recordings/{game}?run={run_id}" for game in pair.sides]
        told.get_by_role("button", name="Back to the run").click()
        figure = page.get_by_text("Closer to what was meant (blind comparison)").locator("..")
        expect(figure).to_contain_text(f"{wins / N_PAIRS:.0%}")
        expect(page.get_by_role("button", name="Compare more pairs")).to_be_focused()
