"""A whole Tril with a data folder of its own, and a real browser before it."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

import pytest
from playwright.sync_api import Browser, Page, sync_playwright

from server.web.pages import FRONTEND
from tests.e2e.pages import DESKTOP, watched_page
from tests.e2e.running import BROWSER_ARGUMENTS, RunningTril, start_tril
from tests.server.live import LiveServer, live_server
from tests.workplace import make_workplace


@pytest.fixture(scope="session")
def browser(chromium: Path) -> Iterator[Browser]:
    """Return a headless Chromium."""
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(
            executable_path=str(chromium),
            headless=True,
            chromium_sandbox=os.geteuid() != 0,
            args=BROWSER_ARGUMENTS,
        )
        yield browser
        browser.close()


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> Iterator[LiveServer]:
    """Return a running server with the built pages, and nothing else of a Tril."""
    made = make_workplace(tmp_path_factory.mktemp("playing") / "data")
    made.database.close()
    with live_server(made.settings.data, frontend=FRONTEND) as running:
        yield running


@pytest.fixture(scope="module")
def running_tril(tmp_path_factory: pytest.TempPathFactory) -> Iterator[RunningTril]:
    """Return a Tril that runs for the tests of one module."""
    running = start_tril(tmp_path_factory.mktemp("e2e") / "data")
    yield running
    status = running.stop()
    assert status == 0, "".join(running.output[-60:])


@pytest.fixture
def page(browser: Browser, running_tril: RunningTril) -> Iterator[Page]:
    """Return a signed-in page; errors in its console fail the test."""
    context = browser.new_context(viewport=DESKTOP)
    with watched_page(context, running_tril.address) as page:
        yield page
