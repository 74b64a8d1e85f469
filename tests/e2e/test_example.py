"""The finished example in a real browser: one click from the empty page to everything of a run."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import pytest
from playwright.sync_api import Browser, expect

from server.web.pages import FRONTEND
from tests.e2e.pages import DESKTOP, signed_in
from testsupport.live import LiveServer, live_server
from testsupport.watching import running_inference
from testsupport.workplace import Workplace
from tril.exchange.example import BEHAVIOUR_NAME
from tril.settings import Settings
from tril.store.database import create_database
from tril.store.schema import upgrade

PATIENCE_MS = 60_000
"""The first answer of a network waits until it is loaded."""


@pytest.fixture
def empty(tmp_path: Path) -> Iterator[LiveServer]:
    """Return a running server on an empty data folder, and an inference process beside it."""
    settings = Settings(data=tmp_path / "data")
    settings.data.mkdir()
    database = create_database(settings.application_url)
    upgrade(database)
    with (
        running_inference(Workplace(settings, database, 0, ())),
        live_server(settings.data, frontend=FRONTEND) as running,
    ):
        yield running
    database.close()


def test_the_example_opens_at_once_and_everything_of_it_works(
    browser: Browser, empty: LiveServer
) -> None:
    with signed_in(browser, empty, "/", viewport=DESKTOP) as page:
        page.get_by_role("button", name="Open a finished example").click()
        page.wait_for_url(re.compile("/runs/[0-9a-f-]{36}"))
        verdict = page.get_by_role("region", name="Verdict")
        expect(verdict).to_contain_text("of 6 targets")
        expect(page.get_by_text("It was trained elsewhere")).to_be_visible()
        expect(page.get_by_role("region", name="Take it with you")).to_be_visible()
        expect(page.get_by_role("region", name="What does the reward look at?")).to_be_visible()
        run_address = page.url
        games = page.get_by_role("group", name="Games in step")
        position = games.get_by_role("slider", name="Position in the recording")
        curve = games.get_by_role("slider", name="Position on the curve of R")
        expect(curve).to_be_visible(timeout=PATIENCE_MS)
        expect(games.get_by_role("img", name=re.compile("^Game screen of"))).to_have_count(2)
        position.press("End")
        expect(curve).to_have_attribute("aria-valuenow", position.get_attribute("max") or "")

        page.get_by_role("link", name="Watch the imitator play").click()
        began = page.get_by_text(re.compile(r"^step [1-9]\d* of 300$"))
        expect(began).to_be_visible(timeout=PATIENCE_MS)

        taught = empty.http.get("/api/behaviours").json()[-1]
        assert (taught["name"], taught["n_ranked"]) == (BEHAVIOUR_NAME, 12)
        run_id = run_address.rpartition("/")[2]
        games = empty.http.get(f"/api/runs/{run_id}/results").json()["games"]
        number = games[0]["recording"]["id"]
        reward = empty.http.get(f"/api/runs/{run_id}/reward/{number}").json()
        assert len(reward["levels"]) == games[0]["recording"]["n_steps"] + 1
        seen = empty.http.get(
            f"/api/runs/{run_id}/attention/{number}", params={"step": 50, "method": "gradient"}
        )
        assert len(seen.content) == 84 * 84 * 4

        page.goto("/")
        expect(page.get_by_role("link", name=BEHAVIOUR_NAME, exact=True)).to_be_visible()
