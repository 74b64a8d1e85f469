"""An imitator that plays live in a real browser: watched, stepped, and taken over by a person."""

from __future__ import annotations

import re
from collections.abc import Iterator

import pytest
from playwright.sync_api import Browser, Page, ViewportSize, expect

from server.web.pages import FRONTEND
from tests.e2e.pages import DESKTOP, signed_in
from tests.e2e.playing import expect_running
from testsupport.live import LiveServer, live_server
from testsupport.page_actions import end_and_keep
from testsupport.watching import finished_run, running_inference
from testsupport.workplace import Workplace
from tril.games.space_invaders.memory import FRAMES_PER_STEP
from tril.store import recordings
from tril.store.models import Source

PHONE = ViewportSize(width=360, height=780)
FIRST_STEP = re.compile(r"^step \d+ of 300$")
NOT_BEGUN = "step 0 of 300"
PATIENCE_MS = 60_000
"""The first decision waits until the networks are loaded."""


@pytest.fixture(scope="module")
def run_id(shared_workplace: Workplace) -> str:
    """Return a finished run of column 1 with policies."""
    return finished_run(shared_workplace)


@pytest.fixture(scope="module")
def built(shared_workplace: Workplace, run_id: str) -> Iterator[LiveServer]:
    """Return a running server with the built pages, and an inference process beside it."""
    with (
        running_inference(shared_workplace),
        live_server(shared_workplace.settings.data, frontend=FRONTEND) as running,
    ):
        yield running


def step_of(page: Page) -> int:
    """Return the step that a page with paused games shows, once it has come to rest."""
    shown = -1
    while shown != (shown := int(page.get_by_text(FIRST_STEP).inner_text().split()[1])):
        page.wait_for_timeout(300)
    return shown


def test_an_imitator_is_watched_stepped_and_taken_over(
    browser: Browser, built: LiveServer, shared_workplace: Workplace, run_id: str
) -> None:
    with signed_in(browser, built, f"/runs/{run_id}", viewport=DESKTOP) as page:
        page.get_by_role("link", name="Watch the imitator play").click()
        lane = page.get_by_role("article", name="Game 1: Imitator, greedy")
        expect(page.get_by_role("button", name="Pause")).to_be_visible()
        expect(page.get_by_text(FIRST_STEP)).not_to_have_text(NOT_BEGUN, timeout=PATIENCE_MS)
        expect(lane.get_by_text("Reward R")).not_to_contain_text("–")

        page.get_by_role("combobox", name="Over the picture").select_option(
            "What the reward looks at"
        )
        expect(lane.get_by_role("img", name="What the reward looks at")).to_be_visible()
        expect(lane.get_by_text(re.compile(r"up to .* R$"))).to_be_visible()
        page.get_by_role("combobox", name="Over the picture").select_option("Picture only")
        expect(lane.get_by_role("img", name="What the reward looks at")).to_have_count(0)
        page.get_by_role("combobox", name="Over the picture").blur()

        page.keyboard.press("Space")
        expect(page.get_by_role("button", name="Play Space")).to_be_visible()
        page.keyboard.press("Period")
        expect(page.get_by_role("button", name="Play Space")).to_be_enabled()
        before = step_of(page)
        page.keyboard.press("Period")
        expect(page.get_by_text(f"step {before + 1} of 300")).to_be_visible()
        assert step_of(page) == before + 1
        chosen = lane.get_by_role("listitem").filter(has_text=re.compile(r"\d+%"))
        expect(chosen).to_have_count(6)

        page.keyboard.press("t")
        page.wait_for_url(re.compile("/behaviours/1/play$"))
        expect_running(page)
        page.keyboard.down("ArrowRight")
        page.wait_for_timeout(300)
        page.keyboard.up("ArrowRight")
        recording_id = end_and_keep(page)

        page.goto(f"/recordings/{recording_id}")
        expect(
            page.get_by_text(f"The imitator of Run {run_id[:6]} played the first")
        ).to_be_visible()

    with shared_workplace.database.reading() as session:
        row = recordings.get(session, recording_id)
    watched = (before + 1) * FRAMES_PER_STEP
    assert (row.source, row.state, row.verification) == (Source.PERSON, "kept", "verified")
    assert row.conditions["play"]["begun_by"]["frames"] == watched
    assert row.n_frames > watched
    assert 2 in row.actions[watched:], "the person moved right"


def test_several_policies_are_watched_side_by_side_on_a_phone(
    browser: Browser, built: LiveServer, run_id: str
) -> None:
    path = f"/runs/{run_id}/watch?player=imitator.greedy&player=clone.greedy&start=2"
    with signed_in(browser, built, path, viewport=PHONE) as page:
        expect(page.get_by_role("article")).to_have_count(2)
        page.get_by_role("button", name="Add another beside them").click()
        expect(page.get_by_role("article")).to_have_count(3)
        expect(page.get_by_text(FIRST_STEP)).not_to_have_text(NOT_BEGUN, timeout=PATIENCE_MS)
        width = page.evaluate("document.documentElement.scrollWidth")
        assert width <= PHONE["width"], "nothing is cut off at the side"
        page.get_by_role("button", name="Next start").click()
        beginning = page.get_by_role("paragraph").filter(has_text="Evaluation start 3")
        expect(beginning).to_be_visible()
        expect(page.get_by_role("button", name="Pause")).to_be_visible(timeout=PATIENCE_MS)


@pytest.mark.parametrize("locale", ["en-GB", "de-DE"])
@pytest.mark.parametrize("players", [["imitator.greedy"], ["imitator.greedy", "clone.greedy"]])
def test_watched_games_fit_a_phone(
    browser: Browser, built: LiveServer, run_id: str, players: list[str], locale: str
) -> None:
    path = f"/runs/{run_id}/watch?player={'&player='.join(players)}"
    phone = {"viewport": PHONE, "has_touch": True, "is_mobile": True, "locale": locale}
    with signed_in(browser, built, path, **phone) as page:
        targets = page.get_by_role("article").get_by_text(
            re.compile("^(Targets hit|Getroffene Ziele)")
        )
        expect(targets).to_have_count(len(players))
        assert page.evaluate("document.documentElement.scrollWidth") == PHONE["width"]
