"""A whole Tril with a data folder of its own, and a real browser before it."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from playwright.sync_api import Browser, Page, expect, sync_playwright

from server.web.pages import FRONTEND
from tests.e2e.every_page import EveryPage, serving_every_page
from tests.e2e.pages import DESKTOP, PATIENCE_MS, watched_page
from testsupport.browser import launch_chromium
from testsupport.live import LiveServer, live_server
from testsupport.processes import TrilProcess, whole_tril
from testsupport.replays import shared_replays
from testsupport.workplace import Workplace, make_workplace

LENGTHY = (
    "test_screenshots",
    "test_accessibility",
    "test_first_visit",
    "test_other_browsers",
    "test_main_path",
    "test_varied_games",
    "test_playing",
    "test_comparing",
)
"""Files that take longest, in this order: begun last, one of them would run on alone."""


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Put the lengthy files first."""
    items.sort(key=lambda item: _position(item.path.stem))


def _position(file: str) -> int:
    return LENGTHY.index(file) if file in LENGTHY else len(LENGTHY)


@pytest.fixture(scope="session", autouse=True)
def _shared_replays() -> Iterator[None]:
    with shared_replays():
        yield


@pytest.fixture(scope="session")
def browser() -> Iterator[Browser]:
    """Return a headless Chromium."""
    expect.set_options(timeout=PATIENCE_MS)
    with sync_playwright() as playwright:
        browser = launch_chromium(playwright)
        yield browser
        browser.close()


@pytest.fixture(scope="module")
def shared_workplace(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Workplace]:
    """Return a data folder with four ranked recordings, which a module's tests share."""
    made = make_workplace(tmp_path_factory.mktemp("shared") / "data")
    yield made
    made.database.close()


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> Iterator[LiveServer]:
    """Return a running server with the built pages, and nothing else of a Tril."""
    made = make_workplace(tmp_path_factory.mktemp("playing") / "data")
    made.database.close()
    with live_server(made.settings.data, frontend=FRONTEND) as running:
        yield running


@pytest.fixture(scope="module")
def every_page(tmp_path_factory: pytest.TempPathFactory) -> Iterator[EveryPage]:
    """Return a running server with all pages filled."""
    with serving_every_page(tmp_path_factory.mktemp("pages") / "data") as pages:
        yield pages


@pytest.fixture(scope="module")
def running_tril(tmp_path_factory: pytest.TempPathFactory) -> Iterator[TrilProcess]:
    """Return a Tril that runs for the tests of one module."""
    with whole_tril(tmp_path_factory.mktemp("e2e") / "data") as running:
        yield running


@pytest.fixture
def page(browser: Browser, running_tril: TrilProcess) -> Iterator[Page]:
    """Return a signed-in page; errors in its console fail the test."""
    context = browser.new_context(viewport=DESKTOP)
    with watched_page(context, running_tril.address) as page:
        yield page
