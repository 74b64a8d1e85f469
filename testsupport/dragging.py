"""Dragging by the mouse in a real browser."""

from __future__ import annotations

import time

from playwright.sync_api import Locator, Page

DRAG_TIMEOUT_S = 20


def drag_into(page: Page, handle: Locator, target: Locator, announced: str) -> None:
    """Drag as a person does: after the place while the page scrolls, until it stays lit.

    Args:
        page: The page of both.
        handle: What is dragged.
        target: Where it is dropped.
        announced: What the page calls the place.
    """
    handle.scroll_into_view_if_needed()
    start = handle.bounding_box()
    assert start is not None
    page.mouse.move(start["x"] + start["width"] / 2, start["y"] + start["height"] / 2)
    page.mouse.down()
    page.mouse.move(start["x"] - 20, start["y"] - 20, steps=4)
    lit = page.get_by_text(f"Over {announced}")
    deadline = time.monotonic() + DRAG_TIMEOUT_S
    aimed_at = None
    while not (lit.count() and target.bounding_box() == aimed_at):
        assert time.monotonic() < deadline, f"the page does not say: Over {announced}"
        aimed_at = target.bounding_box()
        assert aimed_at is not None
        x, y = aimed_at["x"] + aimed_at["width"] / 2, aimed_at["y"] + aimed_at["height"] / 2
        page.mouse.move(x, y, steps=12)
        page.wait_for_timeout(100)
    page.mouse.up()
