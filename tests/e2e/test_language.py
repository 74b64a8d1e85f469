"""Played and ranked in German, the browser's language, from the keyboard."""

from __future__ import annotations

import re

from playwright.sync_api import Browser, Page, expect

from tests.e2e.pages import DESKTOP
from tests.e2e.playing import play_page
from testsupport.live import LiveServer


def test_a_game_is_played_and_ranked_in_german(browser: Browser, built: LiveServer) -> None:
    with play_page(browser, built, viewport=DESKTOP, locale="de-DE") as page:
        expect(page.locator("html")).to_have_attribute("lang", "de")
        path = page.get_by_role("navigation", name="Ablauf")
        expect(path.get_by_role("link", name="Spielen")).to_be_visible()
        name = f"Aufnahme {play(page)}"

        path.get_by_role("link", name="Ordnen").click()
        page.get_by_role("button", name=f"Als beste einordnen: {name}").press("Enter")
        best = page.get_by_role("listitem", name="Stufe 1 von 5, 1 Aufnahme")
        expect(best.get_by_role("heading")).to_have_text(name)
        expect(page.get_by_role("status").get_by_text("Gespeichert")).to_be_visible()

        page.get_by_role("button", name=f"{name} verschieben", exact=True).press("Space")
        expect(page.get_by_text(f"{name} angehoben.")).to_be_attached()
        # dnd-kit listens to the arrow keys from a timer on.
        page.evaluate("() => new Promise((done) => setTimeout(done))")
        for key, announced in (
            ("ArrowDown", "Platz: neue Stufe zwischen den Stufen 1 und 2."),
            ("ArrowDown", "Platz: Stufe 2 von 5, mit 1 Aufnahme."),
            ("Space", f"{name} abgelegt: Stufe 2 von 5, mit 1 Aufnahme."),
        ):
            page.keyboard.press(key)
            expect(page.get_by_text(announced)).to_be_attached()
        tied = page.get_by_role("listitem", name="Stufe 1 von 4, 2 Aufnahmen")
        expect(tied.get_by_role("heading", name=name)).to_be_visible()
        # It is another element in another tier.
        handle = tied.get_by_role("button", name=f"{name} verschieben", exact=True)
        expect(handle).to_be_focused()


def play(page: Page) -> int:
    """Begin a game by a key, play for a moment and keep it; returns its recording."""
    expect(page.get_by_role("button", name="Spiel starten")).to_be_visible()
    page.keyboard.press("Space")
    timer = page.get_by_role("timer", name="Verbleibende Zeit")
    expect(timer).to_contain_text(re.compile(r"noch 1\d,\d\ss"))
    page.get_by_role("button", name="Das Spiel hier beenden").click()
    page.get_by_role("button", name="Behalten K").click()
    said = page.get_by_text(re.compile(r"Als Aufnahme \d+ behalten"))
    return int(re.sub(r"\D", "", said.inner_text()))
