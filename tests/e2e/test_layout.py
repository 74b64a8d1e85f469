"""How much of the window the frame of the pages takes, and of the wire their first load."""

from __future__ import annotations

import re

import pytest
from playwright.sync_api import Browser, Response, Route, ViewportSize, expect

from tests.e2e.every_page import EveryPage, settled
from tests.e2e.pages import signed_in

PHONE = ViewportSize(width=360, height=740)
LAPTOP = ViewportSize(width=1280, height=800)
VERDICT_PX = 110
HEAD_PX = 200
FIRST_LOAD_BYTES = 250_000
FONT_BYTES = 60_000
IN_A_BEHAVIOUR = ("play", "recordings", "rank", "train", "runs", "recording", "finished run")
# A film strip is larger than what is seen of it.
CONTENT_TOP = """() => Math.min(...[...document.querySelector('nav[aria-label=Path]').parentElement
  .nextElementSibling.querySelectorAll(':not(img)')].map((one) => one.getBoundingClientRect())
  .filter((box) => box.height > 1).map((box) => box.top))"""


def test_content_begins_high_on_a_phone(browser: Browser, every_page: EveryPage) -> None:
    tops = {}
    options = {"viewport": PHONE, "is_mobile": True, "has_touch": True}
    with signed_in(browser, every_page.server, "/", **options) as page:
        for name in IN_A_BEHAVIOUR:
            settled(page, every_page.paths[name])
            tops[name] = page.evaluate(CONTENT_TOP)
        page.get_by_role("button", name="About this behaviour").click()
        assert page.get_by_role("button", name="Edit the behaviour").is_visible()
    assert {name: top for name, top in tops.items() if not 0 < top < HEAD_PX} == {}


def test_a_result_opens_with_its_games_on_a_phone(browser: Browser, every_page: EveryPage) -> None:
    options = {"viewport": PHONE, "is_mobile": True, "has_touch": True}
    with signed_in(browser, every_page.server, "/", **options) as page:
        settled(page, every_page.paths["finished run"])
        verdict = page.get_by_role("region", name="Verdict").bounding_box()
        screen = page.get_by_role("img", name="Game screen of imitator").bounding_box()
        further = page.get_by_role("region", name="What to do next").bounding_box()
    assert verdict
    assert screen
    assert further
    assert verdict["height"] < VERDICT_PX, "at most three lines"
    assert verdict["y"] < screen["y"]
    assert screen["y"] + screen["height"] <= PHONE["height"]
    assert further["y"] > screen["y"] + screen["height"]


def test_opinions_of_a_ranking_move_nothing_when_they_come(
    browser: Browser, every_page: EveryPage
) -> None:
    with signed_in(browser, every_page.server, "/") as page:
        page.set_viewport_size(LAPTOP)
        held: list[Route] = []
        page.route("**/ranking/opinion", lambda route: held.append(route))
        with page.expect_request("**/ranking/opinion"):
            page.goto(every_page.paths["rank"])
        cards = page.get_by_role("list", name="Tiers, best first").get_by_role("article")
        expect(cards).to_have_count(4)
        before = [card.bounding_box() for card in cards.all()]
        for route in held:
            route.continue_()
        page.unroute("**/ranking/opinion")
        expect(page.get_by_text(re.compile("^The others suggest"))).to_have_count(4)
        assert [card.bounding_box() for card in cards.all()] == before


@pytest.mark.parametrize("name", ["behaviours", "play"])
def test_the_first_load_is_small_with_its_letters(
    browser: Browser, every_page: EveryPage, name: str
) -> None:
    sizes: dict[str, int] = {}

    def measure(response: Response) -> None:
        if "/api/" not in response.url:
            sizes[response.url] = response.request.sizes()["responseBodySize"]

    with signed_in(browser, every_page.server, "about:blank") as page:
        page.on("response", measure)
        settled(page, every_page.paths[name])
    fonts = [size for url, size in sizes.items() if url.endswith(".woff2")]
    assert fonts
    assert sum(fonts) < FONT_BYTES
    assert sum(sizes.values()) < FIRST_LOAD_BYTES
