"""Five tasks of a first-time visitor, by what the pages say alone, and what each takes."""

from __future__ import annotations

import re
import zipfile
from collections.abc import Iterator
from pathlib import Path

import pytest
from playwright.sync_api import Browser, expect

from server.web.pages import FRONTEND
from tests.e2e.pages import DESKTOP, WITHOUT_INFERENCE, signed_in
from tests.e2e.playing import expect_running
from tests.trainings import checked
from testsupport.finished_runs import make_finished_run
from testsupport.live import LiveServer, live_server
from testsupport.page_actions import Visitor
from testsupport.waiting import wait_until
from testsupport.workplace import Workplace
from tril.settings import Settings
from tril.store.database import create_database
from tril.store.models import RunStatus
from tril.store.schema import upgrade
from tril.store.training import leases

COLUMN_2 = Path(__file__).parents[1] / "data" / "column-2.jsonl"
N_RANKED = 12
ADVICE = "The reward model orders the games at random. Rank other demonstrations."
ARCHIVE_TIMEOUT_MS = 120_000


def expect_at_most(visitor: Visitor, task: str, clicks: int, keys: int = 0) -> None:
    """Print what a task took, and hold it against a bound."""
    print(f"| {task} | {visitor.clicks} | {visitor.keys} |")
    assert visitor.clicks <= clicks, task
    assert visitor.keys <= keys, task


@pytest.fixture
def empty(tmp_path: Path) -> Iterator[LiveServer]:
    """Return a running server on an empty data folder."""
    settings = Settings(data=tmp_path / "data")
    settings.data.mkdir()
    database = create_database(settings.application_url)
    upgrade(database)
    database.close()
    with live_server(settings.data, frontend=FRONTEND) as running:
        yield running


@pytest.fixture(scope="module")
def used(shared_workplace: Workplace) -> Iterator[LiveServer]:
    """Return a running server with games to rank, a finished run and one that was stopped."""
    make_finished_run(shared_workplace)
    stopped = shared_workplace.make_run(go_on_anyway=False)
    lease = shared_workplace.lease(stopped)
    with shared_workplace.database.writing() as session:
        for stage in ("trajectories", "reward", "check"):
            row = leases.finish_stage(session, lease, stage, 1.0)
        row.outcome = checked({}, passed=False, advice=ADVICE)
        leases.end(session, lease, RunStatus.STOPPED, ADVICE)
    with live_server(shared_workplace.settings.data, frontend=FRONTEND) as running:
        games = COLUMN_2.read_text().splitlines()[:N_RANKED]
        running.http.post(
            "/api/behaviours/2/recordings/import", content="\n".join(games)
        ).raise_for_status()
        yield running


def test_to_see_what_an_example_learned(browser: Browser, empty: LiveServer) -> None:
    with signed_in(browser, empty, "/", viewport=DESKTOP) as page:
        visitor = Visitor(page)
        visitor.click(page.get_by_role("button", name="Open a finished example"))
        expect(page.get_by_role("region", name="Verdict")).to_contain_text("of 6 targets")
        expect_at_most(visitor, "See an example's result", clicks=1)


def test_to_play_and_keep_a_game(browser: Browser, empty: LiveServer) -> None:
    with signed_in(browser, empty, "/", viewport=DESKTOP) as page:
        visitor = Visitor(page)
        visitor.follow("Play your first game")
        visitor.click(page.get_by_role("button", name="Start game"))
        expect_running(page)
        visitor.press("Space")
        visitor.press("ArrowRight")
        visitor.click(page.get_by_role("button", name="End the game here"))
        visitor.click(page.get_by_role("button", name="Keep K"))
        expect(page.get_by_text(re.compile(r"Kept as recording \d+"))).to_be_visible()
        expect_at_most(visitor, "Play and keep a game", clicks=4, keys=2)


def test_to_rank_twelve_games(browser: Browser, used: LiveServer) -> None:
    with signed_in(browser, used, "/", viewport=DESKTOP) as page:
        visitor = Visitor(page)
        visitor.follow("Column 2")
        visitor.step("Rank")
        tray = page.get_by_role("region", name=re.compile("^Unranked"))
        # Cards out of sight are not in the document; what is announced counts them, too.
        expect(tray).to_have_accessible_name(f"Unranked, {N_RANKED} recordings")
        tiers = page.get_by_role("list", name="Tiers, best first")
        for ranked in range(1, N_RANKED + 1):
            visitor.click(tray.get_by_role("button", name=re.compile("^Rank as worst")).first)
            tier = re.compile(rf"^Tier \d+ of {ranked}, 1 recording$")
            expect(tiers.get_by_role("listitem", name=tier)).to_have_count(ranked)
        wait_until(lambda: n_tiers(used) == N_RANKED)
        expect_at_most(visitor, "Rank twelve games", clicks=2 + N_RANKED)


def n_tiers(server: LiveServer) -> int:
    """Return the number of tiers of column 2 that are saved."""
    return len(server.http.get("/api/behaviours/2/ranking").json()["tiers"])


def test_to_find_out_why_a_run_stopped(browser: Browser, used: LiveServer) -> None:
    with signed_in(browser, used, "/", viewport=DESKTOP) as page:
        visitor = Visitor(page)
        visitor.follow("Column 1")
        visitor.step("Look")
        row = page.get_by_role("row").filter(has_text="Stopped")
        visitor.click(row.get_by_role("link").first)
        expect(page.get_by_text(ADVICE).first).to_be_visible()
        expect_at_most(visitor, "Find out why a run stopped", clicks=3)


def test_to_download_the_policy(browser: Browser, used: LiveServer, tmp_path: Path) -> None:
    with signed_in(browser, used, "/", WITHOUT_INFERENCE, viewport=DESKTOP) as page:
        visitor = Visitor(page)
        visitor.follow("Column 1")
        visitor.step("Look")
        row = page.get_by_role("row").filter(has_text="Done")
        visitor.click(row.get_by_role("link").first)
        with page.expect_download(timeout=ARCHIVE_TIMEOUT_MS) as waiting:
            visitor.click(page.get_by_role("button", name="Everything as a zip"))
        waiting.value.save_as(tmp_path / "run.zip")
        expect_at_most(visitor, "Download the policy", clicks=4)
    with zipfile.ZipFile(tmp_path / "run.zip") as archive:
        assert {"policy/imitator.zip", "policy/imitator.safetensors"} <= set(archive.namelist())
