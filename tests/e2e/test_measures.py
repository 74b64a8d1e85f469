"""A ready-made behaviour, its measures in the form, and the checklist of a game."""

from __future__ import annotations

import re

from playwright.sync_api import Browser, expect

from tests.e2e.pages import DESKTOP, signed_in
from tests.e2e.playing import name_of
from testsupport.live import LiveServer
from testsupport.page_actions import end_and_keep


def test_a_ready_made_behaviour_is_taken_played_and_checked(
    browser: Browser, built: LiveServer
) -> None:
    with signed_in(browser, built, "/games/pong", viewport=DESKTOP) as page:
        page.get_by_role("button", name="Teach Stay up").click()
        dialog = page.get_by_role("dialog")
        asked = "Green paddle in the upper 54% of the screen: at least 90% of the time"
        measure = dialog.get_by_role("group", name=asked)
        expect(measure).to_be_visible()
        expect(measure.get_by_role("button", name="Area 1")).to_be_visible()
        dialog.get_by_role("button", name="Measure something").click()
        added = dialog.get_by_role("group", name=re.compile("Green paddle in the left 50%"))
        added.get_by_label("What is measured").select_option("How long the game lasts")
        bound = dialog.get_by_label("At least, seconds")
        bound.press_sequentially("e")
        dialog.get_by_role("button", name="Create behaviour").click()
        expect(bound).to_be_focused()
        expect(bound).to_have_accessible_description("Type a number.")
        bound.fill("1")
        dialog.get_by_role("button", name="Create behaviour").click()
        page.wait_for_url("**/play")
        page.get_by_role("button", name="Start game").click()
        expect(page.get_by_role("button", name="Pause")).to_be_visible()
        expect(page.locator("strong[role=timer]")).to_be_hidden(timeout=15_000)
        page.wait_for_timeout(1000)
        recording = end_and_keep(page)
        page.get_by_role("link", name=re.compile("Recordings")).click()
        card = page.get_by_role("article", name=name_of(built, recording))
        expect(card).to_contain_text(re.compile(r"[12] of 2 measures met"))
        card.get_by_role("link", name=name_of(built, recording)).click()
        checks = page.get_by_role("list", name="Measures").get_by_role("listitem")
        expect(checks).to_have_count(2)
        expect(checks.first).to_contain_text(re.compile(r"\d+% of the time$"))
        expect(checks.last.get_by_role("img", name="met", exact=True)).to_be_visible()
