"""Pages in a real browser, signed in and watched."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from playwright.sync_api import Browser, BrowserContext, ConsoleMessage, Page, ViewportSize

from testsupport.live import LiveServer, cookie

DESKTOP = ViewportSize(width=1280, height=900)
PATIENCE_MS = 30_000
WITHOUT_INFERENCE = "503 (Service Unavailable)"
"""What the browser says of the R of a finished run's games where no process knows it."""


@contextmanager
def watched_page(
    context: BrowserContext, address: str, expected: str | None = None
) -> Iterator[Page]:
    """Open a page for a block; errors in its console fail the test.

    Args:
        context: The browser's context.
        address: Of the page.
        expected: Words of errors that the test makes itself.
    """
    page = context.new_page()
    problems: list[str] = []

    def hear(message: ConsoleMessage) -> None:
        if message.type == "error" and not (expected and expected in message.text):
            problems.append(message.text)

    page.on("pageerror", lambda error: problems.append(str(error)))
    page.on("console", hear)
    page.set_default_timeout(PATIENCE_MS)
    page.goto(address)
    yield page
    context.close()
    assert not problems, problems


@contextmanager
def signed_in(
    browser: Browser,
    server: LiveServer,
    path: str,
    expected: str | None = None,
    /,
    **options: Any,
) -> Iterator[Page]:
    """Open one of a server's pages for a block; see watched_page.

    Args:
        browser: The browser.
        server: A server with the built pages.
        path: Of the page.
        expected: Words of errors that the test makes itself.
        options: Of the browser's context, as its viewport.
    """
    address = f"http://{server.authority}"
    context = browser.new_context(base_url=address, **options)
    name, value = cookie(server.settings).split("=", 1)
    context.add_cookies([{"name": name, "value": value, "url": address}])
    with watched_page(context, path, expected) as page:
        yield page
