"""Every page looks as it did when its picture was last approved.

The pictures are those of tests/e2e/screenshots; `make screenshots` takes them anew. Each run leaves
the whole pictures in test-results/screenshots, with what differs marked red where a test fails.
"""

from __future__ import annotations

import io
import os
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Literal

import numpy as np
import pytest
from PIL import Image
from playwright.sync_api import Browser, Page, Request

from tests.e2e.every_page import EveryPage, settled
from tests.e2e.pages import signed_in
from tests.e2e.picture_comparison import (
    BLOCK_PX,
    Blocks,
    Difference,
    blocks_of,
    compare,
    load,
    save,
)

KEPT = Path(__file__).with_name("screenshots")
RESULTS = Path(__file__).parents[2] / "test-results" / "screenshots"
RENEWED = "TRIL_RENEW_SCREENSHOTS" in os.environ

EVENTS = "/api/events"
ALL_PICTURES = """async () => {
  await document.fonts.ready;
  for (const picture of document.images) picture.loading = "eager";
  await Promise.all([...document.images].map((picture) => picture.decode().catch(() => {})));
}"""

SAME_WORDS = r"""() => {
  const same = [
    [/\d{1,2} [A-Z][a-z]{2,8} \d{4}/g, "23 Nov 2026"],
    [/\d{2}:\d{2}/g, "12:00"],
    [/just now|\d+ (s|min) ago/g, "2 min ago"],
    [/Run [0-9a-f]{6}/g, "Run 0a1b2c"],
  ];
  const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  while (walker.nextNode()) {
    const node = walker.currentNode;
    const text = same.reduce((before, [what, by]) => before.replace(what, by), node.data);
    if (text !== node.data) node.data = text;
  }
}"""
"""Replaces dates and names that are never the same: they could break a line elsewhere."""

WIDTHS = {360: 740, 1280: 800, 2560: 1440}
MOST_PICTURES = 8
THEMES: tuple[Literal["light", "dark"], ...] = ("light", "dark")
PAGES = (
    "behaviours",
    "play",
    "recordings",
    "rank",
    "train",
    "runs",
    "empty ranking",
    "recording",
    "finished run",
    "stopped run",
    "waiting run",
    "compared runs",
    "no page",
)


class Loads:
    """The answers that a page waits for."""

    def __init__(self, page: Page) -> None:
        self._page = page
        self._under_way: set[Request] = set()
        page.on("request", self._begin)
        for event in ("requestfinished", "requestfailed"):
            page.on(event, self._end)

    def _begin(self, request: Request) -> None:
        if not request.url.endswith(EVENTS):
            self._under_way.add(request)

    def _end(self, request: Request) -> None:
        self._under_way.discard(request)

    def finish(self) -> None:
        """Wait until there are none for a while, and all pictures in the page are there."""
        self._page.evaluate(ALL_PICTURES)
        quiet = 0
        while quiet < 3:
            self._page.wait_for_timeout(50)
            quiet = 0 if self._under_way else quiet + 1


def picture_of(
    page: Page, loads: Loads, is_right: Callable[[bytes], bool] = lambda _png: False
) -> bytes:
    """Return a picture of the whole page, once it has come to rest.

    Some buttons' edges go on changing by a shade that nobody sees, so there is an end to waiting.
    A picture that is right as it is needs no second one.
    """
    loads.finish()
    page.evaluate(SAME_WORDS)
    before = b""
    for _ in range(MOST_PICTURES):
        now = page.screenshot(full_page=True, animations="disabled")
        if now == before or is_right(now):
            return now
        before = now
        page.wait_for_timeout(100)
    return before


def dress(page: Page) -> None:
    """Give a page the same letters on every machine: its own, for code too, and no blinking."""
    page.add_style_tag(
        content=":root { --mono: var(--sans) } * { caret-color: transparent !important }"
    )


def show_difference(png: bytes, difference: Difference, path: Path) -> None:
    """Write a picture with the blocks that differ in red."""
    picture = np.asarray(Image.open(io.BytesIO(png)).convert("RGB")).copy()
    for row, column in np.argwhere(difference.where).tolist():
        top, left = row * BLOCK_PX, column * BLOCK_PX
        picture[top : top + BLOCK_PX, left : left + BLOCK_PX, 0] = 255
    Image.fromarray(picture).save(path)


def _looks_like(kept: Blocks | None, png: bytes) -> bool:
    return kept is not None and not compare(kept, blocks_of(png)).is_noticeable


@pytest.mark.parametrize("name", PAGES)
def test_a_page_looks_as_it_did(browser: Browser, every_page: EveryPage, name: str) -> None:
    differing = []
    options = {"bypass_csp": True, "reduced_motion": "reduce"}
    with signed_in(browser, every_page.server, "/", **options) as page:
        loads = Loads(page)
        settled(page, every_page.paths[name])
        dress(page)
        for width, height in WIDTHS.items():
            page.set_viewport_size({"width": width, "height": height})
            for theme in THEMES:
                page.emulate_media(color_scheme=theme)
                title = f"{name.replace(' ', '-')}-{width}-{theme}.png"
                kept = None if RENEWED else load(KEPT / title)
                png = picture_of(page, loads, partial(_looks_like, kept))
                RESULTS.mkdir(parents=True, exist_ok=True)
                (RESULTS / title).write_bytes(png)
                if kept is None:
                    save(blocks_of(png), KEPT / title)
                    continue
                difference = compare(kept, blocks_of(png))
                if difference.is_noticeable:
                    show_difference(png, difference, RESULTS / f"differs-{title}")
                    differing.append(f"{title}: {difference.share:.1%}")
    assert not differing, f"See {RESULTS}; make screenshots approves what is right there."


def test_every_page_has_its_pictures(every_page: EveryPage) -> None:
    # The page of people lists the browsers that the tests before have signed in.
    assert set(every_page.paths) - {"people"} == set(PAGES)
    assert len(list(KEPT.glob("*.png"))) == len(PAGES) * len(WIDTHS) * len(THEMES)


@pytest.mark.parametrize(
    ("style", "is_noticed"),
    [
        ("main { padding-block-start: 60px !important }", True),
        ("main > :last-child { visibility: hidden }", True),
        ("h1 { font-weight: 400; opacity: 0.95 }", False),
    ],
)
def test_what_a_person_would_notice_is_noticed(
    browser: Browser, every_page: EveryPage, style: str, is_noticed: bool
) -> None:
    options = {"bypass_csp": True, "reduced_motion": "reduce"}
    with signed_in(browser, every_page.server, "/", **options) as page:
        loads = Loads(page)
        settled(page, every_page.paths["train"])
        dress(page)
        before = blocks_of(picture_of(page, loads))
        page.add_style_tag(content=style)
        assert compare(before, blocks_of(picture_of(page, loads))).is_noticeable == is_noticed
