"""A finished run in a real browser: its games are ranked, and its imitator is trained further."""

from __future__ import annotations

import re
from collections.abc import Iterator

import pytest
from playwright.sync_api import Browser, Page, expect

from server.web.pages import FRONTEND
from tests.e2e.pages import DESKTOP, WITHOUT_INFERENCE, signed_in
from testsupport.live import LiveServer, live_server
from testsupport.workplace import Workplace
from tril.games.behaviours import Score
from tril.recording import verify
from tril.store import recordings
from tril.store.models import RunStatus, Source
from tril.store.training import artifacts, evaluations, leases
from tril.store.training.evaluations import EvaluationKey

N_GAMES = 3


@pytest.fixture
def run_id(workplace: Workplace) -> str:
    """Return a finished run of column 1 with an imitator and a few of its games."""
    made = workplace.make_run()
    lease = workplace.lease(made)
    with workplace.database.writing() as session:
        for start, key in enumerate(workplace.ranked[:N_GAMES], start=3):
            game = recordings.as_recording(recordings.get(session, key))
            row = recordings.add(
                session,
                workplace.behaviour_id,
                game,
                verify(game).replay,
                Source.POLICY,
                run_id=made,
            )
            name = EvaluationKey("imitator", "greedy", start)
            evaluations.add(session, made, name, row.id, True, 1.0, 0.5, Score(start - 3, 0, 0))
        artifacts.save(session, made, "imitator", "imitator.zip", "application/zip", 1)
        leases.end(session, lease, RunStatus.DONE)
    return made


@pytest.fixture
def built(workplace: Workplace, run_id: str) -> Iterator[LiveServer]:
    """Return a running server with the built pages, on the folder of the finished run."""
    with live_server(workplace.settings.data, frontend=FRONTEND) as running:
        yield running


@pytest.fixture
def page(browser: Browser, built: LiveServer, run_id: str) -> Iterator[Page]:
    """Return the run's page; errors in its console fail the test."""
    with signed_in(
        browser, built, f"/runs/{run_id}#teach", WITHOUT_INFERENCE, viewport=DESKTOP
    ) as page:
        yield page


def test_a_runs_games_are_ranked_and_its_imitator_is_trained_further(
    page: Page, run_id: str, workplace: Workplace
) -> None:
    name = f"Run {run_id[:6]}"
    proposed = page.get_by_role("list", name="Games to rank")
    expect(proposed.get_by_role("listitem")).to_have_count(N_GAMES)
    proposed.get_by_role("button", name=re.compile("^Add to the ranking")).first.click()
    proposed.get_by_role("button", name=re.compile("^In the ranking")).click()
    expect(proposed.get_by_role("button", name=re.compile("^Add to"))).to_have_count(N_GAMES)

    page.get_by_role("button", name=f"Add {N_GAMES} games and rank them").click()
    page.wait_for_url(re.compile(rf"/rank\?continue={run_id}$"))
    tray = page.get_by_role("region", name=re.compile("Unranked"))
    expect(tray.get_by_text(f"from {name}")).to_have_count(N_GAMES)
    tray.get_by_role("button", name=re.compile("^Rank as worst")).first.click()
    expect(page.get_by_text("Saved", exact=True)).to_be_visible()

    page.reload()
    page.get_by_role("link", name="Continue to Train").click()
    expect(page.get_by_text(f"Continues {name}: PPO begins with its imitator")).to_be_visible()
    page.go_back()
    page.go_back()
    expect(page.get_by_role("button", name=re.compile("^Ranked: Recording"))).to_have_count(1)
    page.get_by_role("link", name="Train further from this imitator").click()
    expect(page.get_by_text(f"Continues {name}: PPO begins with its imitator")).to_be_visible()
    page.get_by_role("button", name="Train", exact=True).click()
    page.wait_for_url(re.compile(rf"/runs/(?!{run_id})"))
    expect(page.get_by_text(f"Continues {name}")).to_be_visible()

    child = workplace.run(page.url.rsplit("/", 1)[-1])
    assert child.parent_run_id == run_id
    assert child.snapshot is not None
    assert len(child.snapshot.tiers) == len(workplace.ranked) + 1
