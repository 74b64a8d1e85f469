"""How much of the window the frame of the pages takes, and of the wire their first load."""

from __future__ import annotations

import pytest
from playwright.sync_api import Browser, Response, ViewportSize

from tests.e2e.every_page import EveryPage, settled
from tests.e2e.pages import signed_in

PHONE = ViewportSize(width=360, height=740)
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
