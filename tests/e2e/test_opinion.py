"""What the other games suggest, in a real browser: worked out, looked at and followed."""

from __future__ import annotations

import re
from collections.abc import Iterator

import numpy as np
import pytest
from playwright.sync_api import Browser, Page, ViewportSize, expect

from server.web.pages import FRONTEND
from tests.e2e.pages import signed_in
from testsupport.live import live_server
from testsupport.workplace import Workplace
from tril.demonstrators import play_randomly
from tril.games.space_invaders import SPACE_INVADERS
from tril.store import rankings, recordings
from tril.store.models import Source

N_GAMES = 12
PATIENCE_MS = 60_000
PHONE = ViewportSize(width=360, height=780)


@pytest.fixture
def misplaced(workplace: Workplace) -> int:
    """Rank games by their hits, the best of all below the worst, and return that one."""
    rng = np.random.default_rng(3)
    played = [play_randomly(rng, SPACE_INVADERS.make_console()) for _ in range(2 * N_GAMES)]
    played.sort(key=lambda one: len(one.replay.taken), reverse=True)
    with workplace.database.writing() as session:
        ids = [
            recordings.add(session, 1, one.recording, one.replay, Source.VARIED).id
            for one in played
        ]
        best, *others = ids
        rankings.save(session, 1, 1, [[key] for key in (*others, best)])
    return best


@pytest.fixture
def page(browser: Browser, workplace: Workplace, misplaced: int) -> Iterator[Page]:
    """Return the rank page of column 1 on a phone; errors in its console fail the test."""
    with (
        live_server(workplace.settings.data, frontend=FRONTEND) as running,
        signed_in(browser, running, "/behaviours/1/rank", viewport=PHONE) as page,
    ):
        yield page


def test_a_misplaced_game_is_moved_where_the_others_suggest(page: Page, misplaced: int) -> None:
    wanted = page.get_by_role("region", name="What this order asks for")
    expect(wanted).to_be_visible(timeout=PATIENCE_MS)
    tiers = page.get_by_role("listitem", name=re.compile(r"^Tier \d+ of \d+, 1 recording$"))
    expect(tiers).to_have_count(2 * N_GAMES)
    for tier in tiers.all():
        # A card far out of sight is only a place.
        tier.scroll_into_view_if_needed()
        expect(tier.get_by_text(re.compile("^The others suggest tier"))).to_be_visible()
    expect(page.get_by_text(re.compile("^Probably tier"))).to_have_count(4)
    card = page.get_by_role("article", name=f"Recording {misplaced}", exact=True)
    card.get_by_text(re.compile("^The others suggest tier")).click()
    move = card.get_by_role("button", name=re.compile(r"^Move to tier \d"))
    expect(card).to_contain_text("By what it hits, it belongs higher")
    width = page.evaluate("document.documentElement.scrollWidth")
    assert width <= PHONE["width"], "nothing is cut off at the side"

    move.focus()
    page.keyboard.press("Enter")
    expect(page.get_by_text("Saved", exact=True)).to_be_visible()
    handle = page.get_by_role("button", name=f"Move Recording {misplaced}", exact=True)
    expect(handle).to_be_focused()
    expect(card.get_by_text("The other games suggest that")).to_have_count(0)
