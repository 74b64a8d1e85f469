"""A page that is sent: opened from a file, where there is no server and no network."""

from __future__ import annotations

from pathlib import Path

import pytest
from playwright.sync_api import Browser, Locator, Page, Request, expect

from server.web.pages import FRONTEND, share_parts
from tests.e2e.pages import DESKTOP, signed_in, watched_page
from testsupport.finished_runs import make_finished_run
from testsupport.live import live_server
from testsupport.workplace import Workplace, make_workplace
from trainer.sharing.gallery import write_gallery
from trainer.sharing.page import Parts
from tril.files.artifact_store import ArtifactStore

PICTURE = "canvas => canvas.toDataURL()"


@pytest.fixture(scope="module")
def finished(tmp_path_factory: pytest.TempPathFactory) -> tuple[Workplace, str]:
    """Return a data folder with a finished run, and the run."""
    made = make_workplace(tmp_path_factory.mktemp("sharing") / "data")
    return made, make_finished_run(made)


@pytest.fixture(scope="module")
def index(finished: tuple[Workplace, str], tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the index of a gallery of one page."""
    made, run_id = finished
    store = ArtifactStore(made.settings.artifact_root)
    folder = tmp_path_factory.mktemp("gallery")
    parts = Parts(*share_parts())
    return write_gallery(
        made.database, store, {"column-1": run_id}, made.settings.data, parts, folder
    )


def test_a_page_plays_its_games_alone(browser: Browser, index: Path) -> None:
    requests: list[str] = []

    def hear(request: Request) -> None:
        if not request.url.startswith(("file:", "data:")):
            requests.append(request.url)

    context = browser.new_context(viewport=DESKTOP, offline=True)
    context.on("request", hear)
    with watched_page(context, index.as_uri()) as page:
        page.get_by_role("link", name="Column 1").click()
        expect(page.get_by_role("heading", name="Column 1")).to_be_visible()
        screens = page.get_by_role("img", name="Game screen of", exact=False)
        expect(screens).to_have_count(2)
        _plays_by_itself(page, screens.first)
        _moves_by_keys(page, screens.first)
        _plays_while_pointed_at(page)
    assert requests == []


def _plays_by_itself(page: Page, screen: Locator) -> None:
    time = page.locator("#time")
    expect(time).to_have_text("4.0 s")  # the end of the games
    end = screen.evaluate(PICTURE)
    page.get_by_role("button", name="Play", exact=True).click()
    expect(page.get_by_role("button", name="Pause")).to_be_visible()
    page.get_by_role("button", name="Pause").click()
    assert screen.evaluate(PICTURE) != end
    expect(page.get_by_role("button", name="Play", exact=True)).to_be_visible()


def _moves_by_keys(page: Page, screen: Locator) -> None:
    position = page.get_by_role("slider", name="Position in the games")
    position.press("Home")
    expect(position).to_have_value("0")
    first, dot = screen.evaluate(PICTURE), page.locator("#cursor circle").first
    expect(dot).to_have_attribute("cx", "0%")
    position.press("Shift+ArrowRight")
    expect(position).to_have_value("4")
    assert screen.evaluate(PICTURE) != first
    position.press("End")
    expect(position).to_have_value("240")
    expect(dot).to_have_attribute("cx", "100%")
    # Back through every difference to the same picture.
    position.press("Home")
    assert screen.evaluate(PICTURE) == first


def _plays_while_pointed_at(page: Page) -> None:
    tile = page.get_by_role("button", name="Place 1, Demonstrator", exact=False)
    canvas = tile.locator("canvas")
    expect(canvas).to_be_hidden()
    tile.hover()
    expect(canvas).to_be_visible()
    before = canvas.evaluate(PICTURE)
    page.wait_for_function(
        "([canvas, before]) => canvas.toDataURL() !== before", arg=[canvas.element_handle(), before]
    )
    page.get_by_role("heading", name="Column 1").hover()
    expect(canvas).to_be_hidden()


@pytest.mark.parametrize("scheme", ["light", "dark"])
# 345 is a phone of 360 whose scroll bar takes room.
@pytest.mark.parametrize("width", [345, 360, 1280, 1920])
def test_a_page_fits_every_width(browser: Browser, index: Path, scheme: str, width: int) -> None:
    context = browser.new_context(
        viewport={"width": width, "height": 740},
        color_scheme=scheme,  # type: ignore[arg-type]
        reduced_motion="reduce",
    )
    with watched_page(context, (index.parent / "column-1.html").as_uri()) as page:
        expect(page.get_by_role("button", name="Play", exact=True)).to_be_visible()
        overflow = page.evaluate("document.documentElement.scrollWidth - innerWidth")
        assert overflow <= 0
        right = "(one) => document.querySelector(one).getBoundingClientRect().right"
        assert page.evaluate(right, "#speed") <= page.evaluate(right, "main") + 0.5
        dark = page.evaluate("getComputedStyle(document.body).backgroundColor") == "rgb(19, 19, 18)"
        assert dark == (scheme == "dark")


def test_the_run_page_saves_a_page_to_send(
    browser: Browser, finished: tuple[Workplace, str], tmp_path: Path
) -> None:
    made, run_id = finished
    with (
        live_server(made.settings.data, frontend=FRONTEND) as running,
        # Nothing answers for R on the run's page; the one that is sent has it.
        signed_in(browser, running, f"/runs/{run_id}", "503", viewport=DESKTOP) as page,
    ):
        with page.expect_download(timeout=300_000) as download:
            page.get_by_role("button", name="Share").click()
        assert download.value.suggested_filename == f"tril-column-1-{run_id[:8]}.html"
        file = tmp_path / "page.html"
        download.value.save_as(file)
    with watched_page(browser.new_context(offline=True), file.as_uri()) as page:
        expect(page.get_by_role("heading", name="Column 1")).to_be_visible()
        expect(page.get_by_role("img", name="Game screen of Imitator")).to_be_visible()
