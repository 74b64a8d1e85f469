"""``tril demo`` from demonstrations to summary, at its smallest, with real processes."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from cli.main import app
from testsupport.recipes import SMALLEST
from trainer.reporting.run_entry import read_entry
from tril.settings import Settings
from tril.store import behaviours, rankings, recordings
from tril.store.database import create_database
from tril.store.models import RunStatus
from tril.store.training import evaluations, runs


def tril(*arguments: str, errors: bool = False) -> str:
    """Run the command to its end; returns what it printed, with its messages if asked for."""
    done = subprocess.run(
        [sys.executable, "-m", "cli", *arguments],
        env={**os.environ, "TRIL_LEARNING_THREADS": "1"},
        capture_output=True,
        text=True,
        timeout=1100,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout + done.stderr if errors else done.stdout


@pytest.mark.lengthy
@pytest.mark.timeout(1200)
def test_the_smallest_demo_is_complete(data_folder: Path, tmp_path: Path) -> None:
    results = tmp_path / "results"
    values = [argument for value in SMALLEST for argument in ("--set", value)]
    tril("demo", "-b", "column-2", "--steps", "64", "--output", str(results), *values)

    page = (results / "README.md").read_text()
    assert "scripted demonstrator" in page
    pictures = set(re.findall(r"\]\(([^)]+\.png)\)", page))
    assert {"aliens.png", "returns.png", "extrapolation.png", "attention-maximum.png"} <= pictures
    assert all((results / name).stat().st_size > 0 for name in pictures)

    database = create_database(Settings().application_url)
    with database.reading() as session:
        behaviour = behaviours.by_slug(session, "column-2")
        (run,) = runs.listing(session, behaviour.id)
        assert run.status == RunStatus.DONE
        check = run.outcome.check
        assert check is not None
        assert check.wanted is not None
        labels = np.reshape(check.wanted.labels, (6, 6))
        assert (labels[:, 1] > 0.5).all()
        assert (labels[0, [0, 2]] < -0.5).all()
        demonstrations = recordings.listing(session, behaviour.id)
        assert {row.source for row in demonstrations} == {"scripted"}
        assert sum(row.perfect for row in demonstrations) == 12
        tiers = rankings.as_ranking(rankings.current(session, behaviour.id)).tiers
        assert [len(tier) for tier in tiers] == [1] * 12
        games = evaluations.listing(session, run.id)
        assert {(game.policy, game.action_selection, game.start_number) for game in games} == {
            (policy, action_selection, number)
            for policy in evaluations.POLICIES
            for action_selection in evaluations.ACTION_SELECTIONS
            for number in (0, 7)
        }
    entry = read_entry(database, run.id)
    assert (entry.cell.behaviour, entry.cell.recipe, entry.cell.steps) == ("column-2", "fast", 64)
    assert set(entry.changes) == {value.partition("=")[0] for value in SMALLEST}
    assert entry.changes["reward.updates"] == 12
    assert entry.changes["evaluation.further_start_numbers"] == [7]
    assert sum(len(played) for played in entry.games.values()) == len(games)
    assert [shown.rank for shown in entry.demonstrations] == list(range(1, 13))
    database.close()

    played = CliRunner().invoke(
        app, ["evaluate", run.id, "--starts", "7", "--action-selection", "sticky", "--json"]
    )
    assert played.exit_code == 0, played.output
    (again,) = played.stdout.splitlines()
    stored = next(
        game
        for game in games
        if (game.policy, game.action_selection, game.start_number) == ("imitator", "sticky", 7)
    )
    assert json.loads(again)["targets"] == stored.targets
    assert json.loads(again)["predicted_return"] == pytest.approx(stored.predicted_return, rel=1e-3)
