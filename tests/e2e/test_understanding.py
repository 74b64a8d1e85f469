"""What Tril understands of an order, in a real browser: seen, agreed with, taken back."""

from __future__ import annotations

import re
from collections.abc import Iterator

import numpy as np
import pytest
from playwright.sync_api import Browser, Page, ViewportSize, expect

from server.web.pages import FRONTEND
from tests.e2e.pages import signed_in
from testsupport.live import live_server
from testsupport.vocabularies import make_small_vocabulary
from testsupport.workplace import Workplace
from tril.demonstrators import play_randomly
from tril.games import game_named
from tril.games.settings import GameSettings
from tril.store import behaviours, rankings, recordings
from tril.store.models import Source

N_GAMES = 15
SETTINGS = GameSettings(max_steps=60)
PATIENCE_MS = 120_000
PHONE = ViewportSize(width=360, height=780)
LAPTOP = ViewportSize(width=1280, height=800)


@pytest.fixture
def behaviour_id(workplace: Workplace, monkeypatch: pytest.MonkeyPatch) -> int:
    """Rank twelve games of Pong, which Tril has learned to see, and leave three unranked."""
    game = game_named("pong").with_settings(SETTINGS)
    make_small_vocabulary(workplace.settings.data, game, monkeypatch)
    console = game.make_console()
    played = [play_randomly(np.random.default_rng(seed), console) for seed in range(N_GAMES)]
    console.close()
    with workplace.database.writing() as session:
        behaviour = behaviours.create(session, "Stay low", game="pong", settings=SETTINGS)
        ids = [
            recordings.add(session, behaviour.id, one.recording, one.replay, Source.VARIED).id
            for one in played
        ]
        rankings.save(session, behaviour.id, 0, [[key] for key in ids[3:]])
        return behaviour.id


@pytest.fixture
def page(browser: Browser, workplace: Workplace, behaviour_id: int) -> Iterator[Page]:
    """Return the behaviour's rank page on a phone; errors in its console fail the test."""
    path = f"/behaviours/{behaviour_id}/rank"
    with (
        live_server(workplace.settings.data, frontend=FRONTEND) as running,
        signed_in(browser, running, path, viewport=PHONE) as page,
    ):
        yield page


def test_a_statement_is_seen_agreed_with_and_taken_back(page: Page) -> None:
    panel = page.get_by_role("region", name="What Tril understood")
    agree = panel.get_by_role("button", name=re.compile("^This is it: "))
    expect(agree.first).to_be_visible(timeout=PATIENCE_MS)
    expect(panel.get_by_text("%").first).to_be_visible()
    width = page.evaluate("document.documentElement.scrollWidth")
    assert width <= PHONE["width"], "nothing is cut off at the side"

    name = agree.first.get_attribute("aria-label")
    assert name is not None
    sentence = name.removeprefix("This is it: ")
    agree.first.focus()
    page.keyboard.press("Enter")
    expect(panel.get_by_text("You said: this is it.").first).to_be_visible()
    back = panel.get_by_role("button", name=f"Take back: {sentence}", exact=True)
    expect(back).to_be_focused()
    expect(back).to_have_attribute("aria-disabled", "false")

    page.reload()
    expect(back).to_be_visible(timeout=PATIENCE_MS)
    back.click()
    expect(panel.get_by_text("You said: this is it.")).to_have_count(0)
    expect(panel.get_by_role("button", name=name, exact=True)).to_be_visible()


def test_the_whole_board_is_seen_without_scrolling(page: Page) -> None:
    page.set_viewport_size(LAPTOP)
    panel = page.get_by_role("region", name="What Tril understood")
    shown = {
        "order": page.get_by_role("list", name="Tiers, best first"),
        "unranked": page.get_by_role("region", name=re.compile("^Unranked, 3 ")),
        "statements": panel,
        "way on": page.get_by_role("link", name="Continue to Train"),
    }
    expect(panel.get_by_role("button", name=re.compile("^This is it: ")).nth(2)).to_be_visible(
        timeout=PATIENCE_MS
    )
    expect(shown["order"].get_by_role("article")).to_have_count(N_GAMES - 3)
    boxes = {name: place.bounding_box() for name, place in shown.items()}
    for card in [
        *shown["order"].get_by_role("article").all(),
        *shown["unranked"].get_by_role("article").all(),
    ]:
        boxes[str(card.get_attribute("aria-label"))] = card.bounding_box()
    hidden = [
        name
        for name, box in boxes.items()
        if box is None
        or box["y"] + box["height"] > LAPTOP["height"]
        or box["x"] + box["width"] > LAPTOP["width"]
    ]
    assert not hidden
    assert boxes["order"]
    assert boxes["statements"]
    assert boxes["order"]["x"] + boxes["order"]["width"] < boxes["statements"]["x"]
    assert page.evaluate("window.scrollY") == 0


def test_moments_are_shown_and_what_is_pointed_at_is_meant_and_taken_back(page: Page) -> None:
    panel = page.get_by_role("region", name="What Tril understood")
    show = panel.get_by_role("button", name=re.compile("^Show: "))
    expect(show.first).to_be_visible(timeout=PATIENCE_MS)
    show.first.click()
    expect(panel.get_by_role("img", name=re.compile("^Game screen of"))).to_have_count(2)
    panel.get_by_role("button", name=re.compile("^Hide: ")).click()
    expect(panel.get_by_role("img", name=re.compile("^Game screen of"))).to_have_count(0)

    point = panel.get_by_role("button", name="Point at it")
    point.click()
    dialog = page.get_by_role("dialog", name="Point at what you mean")
    player = dialog.get_by_role("button", name="the green paddle", exact=True)
    expect(player).to_be_visible()
    boxes = dialog.locator("[data-kind]")
    expect(boxes.first).to_be_visible(timeout=PATIENCE_MS)
    # The list marks the thing in the picture, and the picture the thing in the list.
    kind = boxes.last.get_attribute("data-kind")
    boxes.last.click()
    expect(dialog.locator(f"[data-kind='{kind}'][class*=marked]").first).to_be_visible()
    dialog.get_by_role("button", name="Another thing").click()

    player.focus()
    page.keyboard.press("Enter")
    expect(dialog.get_by_role("heading", name="the green paddle")).to_be_focused()
    # It is called as the person calls it.
    dialog.get_by_role("button", name="Give it a name").click()
    name = dialog.get_by_role("textbox", name="Name")
    expect(name).to_be_focused()
    page.keyboard.type("my bat")
    page.keyboard.press("Enter")
    expect(dialog.get_by_role("heading", name="my bat")).to_be_focused()
    sentence = "my bat higher up or lower down"
    dialog.get_by_role("button", name=sentence).click()
    expect(dialog).to_have_count(0)
    expect(point).to_be_focused()
    expect(panel.get_by_text(re.compile("^You said(:| that) this is it")).first).to_be_visible()
    # Every statement is about it now, in the order's own words.
    first = panel.get_by_role("listitem").first
    meant = r"my bat (higher|lower|.*from the top)"
    expect(first).to_contain_text(re.compile(meant))

    page.reload()
    back = panel.get_by_role("button", name=re.compile("^Take back: my bat"))
    expect(back.first).to_be_visible(timeout=PATIENCE_MS)
    back.first.click()
    expect(panel.get_by_text(re.compile("^You said(:| that) this is it"))).to_have_count(0)
