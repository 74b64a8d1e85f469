"""The ledger of finished results, this version's and that of 0.1.0."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from tests.trainer.reporting.entries import entry
from testsupport.workplace import Workplace
from trainer.reporting import digests
from trainer.reporting.digests import recipe_digest
from trainer.reporting.ledger import Ledger, LedgerCell
from trainer.reporting.run_entry import read_entry
from trainer.reporting.skilled_games import Experiment, Extrapolation, SkilledGame
from tril.errors import Invalid
from tril.recipes import FAST, FAST_0_2, PAPER, Recipe, judged_where_trained, with_values
from tril.store.models import RunStatus, now
from tril.store.training import runs

EXPERIMENT = Experiment.of("shots", FAST_0_2, 3)
GAMES = (SkilledGame(0, 5, 0.5, True), SkilledGame(9, 10, 0.75, False))


def test_added_results_are_read_back_and_no_longer_missing(tmp_path: Path) -> None:
    first, second = entry(seed=0), entry(seed=1)
    ledger = Ledger(tmp_path)
    assert ledger.missing([first.cell, second.cell]) == [first.cell, second.cell]
    ledger.add(first)
    ledger.add(Extrapolation(EXPERIMENT, GAMES))
    again = Ledger(tmp_path)
    assert list(again.entries) == [first]
    assert list(again.extrapolations) == [Extrapolation(EXPERIMENT, GAMES)]
    assert again.missing([first.cell, second.cell]) == [second.cell]
    assert again.missing([EXPERIMENT, replace(EXPERIMENT, training_seed=4)])[0].training_seed == 4
    changed = replace(first, check={})
    again.add(changed)
    assert list(Ledger(tmp_path).entries) == [changed]
    lines = [json.loads(line) for line in again.path.read_text().splitlines()]
    assert [line["version"] for line in lines] == [2, 2]


@pytest.mark.parametrize("line", ['{"cell": {}}', "[]", "{", '{"version": 3, "cell": {}}'])
def test_a_line_that_is_no_result_is_named(tmp_path: Path, line: str) -> None:
    ledger = Ledger(tmp_path)
    ledger.add(entry())
    with ledger.path.open("a") as file:
        file.write(f"{line}\n")
    with pytest.raises(Invalid, match=r"Line 2 of .*ledger\.jsonl"):
        Ledger(tmp_path)


def test_the_digest_changes_with_values_and_not_with_words() -> None:
    assert recipe_digest(FAST_0_2) != recipe_digest(PAPER)
    assert recipe_digest(with_values(FAST_0_2, {"policy.n_epochs": 9})) != recipe_digest(FAST_0_2)
    reworded = replace(FAST_0_2, summary="In other words.", default_steps=1)
    assert recipe_digest(reworded) == recipe_digest(FAST_0_2)


def test_the_digest_changes_with_the_pretrained_weights_that_a_recipe_begins_with(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    before = {recipe: recipe_digest(recipe) for recipe in (FAST, FAST_0_2)}
    other = tmp_path / "other.safetensors"
    other.write_bytes(b"other weights")
    monkeypatch.setattr(digests, "PRETRAINED", other)
    assert recipe_digest(FAST) != before[FAST]
    assert recipe_digest(FAST_0_2) == before[FAST_0_2]
    assert recipe_digest(FAST.reward) != recipe_digest(FAST_0_2.reward)


def test_minutes_leave_out_scripted_demonstrations() -> None:
    assert entry().minutes == 3.0


@pytest.mark.parametrize("status", [RunStatus.CANCELLED, RunStatus.STOPPED, RunStatus.FAILED])
def test_only_a_run_that_is_done_is_a_result(workplace: Workplace, status: RunStatus) -> None:
    run_id = workplace.make_run()
    with workplace.database.writing() as session:
        row = runs.get(session, run_id)
        row.status, row.finished_at = status, now()
    with pytest.raises(Invalid, match=f"{run_id} is {status}"):
        read_entry(workplace.database, run_id)


OWN_START = {
    "policy.own_starts": [2],
    "evaluation.start_numbers": [2],
    "evaluation.further_start_numbers": [],
}


@pytest.mark.parametrize(
    ("recipe", "changes", "found"),
    [
        (with_values(FAST_0_2, {"policy.n_epochs": 9}), {"policy.epochs": 9}, True),
        (judged_where_trained(FAST_0_2, 2), OWN_START, True),
        (FAST_0_2, {"policy.forgotten": 9}, False),
        (FAST_0_2, None, False),
    ],
)
def test_results_of_version_0_1_are_found_if_their_recipe_can_be_rebuilt(
    tmp_path: Path, recipe: Recipe, changes: dict[str, Any] | None, found: bool
) -> None:
    cell = {
        "behaviour": "column-2",
        "recipe": "fast",
        "digest": "01234567",
        "steps": 1000,
        "training_seed": 0,
        "own_starts": recipe.policy.own_starts,
    }
    line = {
        "cell": cell,
        "finished_at": "2026-01-02T03:04:05+00:00",
        "seconds": {"reward": 60.0},
        "check": {"tau": 1.0, "held_out_accuracy": None},
        "demonstrations": [],
        "games": [],
        "versions": {"python": "3.11"},
    }
    text = json.dumps(line if changes is None else line | {"changes": changes})
    (tmp_path / "ledger.jsonl").write_text(text)
    ledger = Ledger(tmp_path)
    assert ledger.missing([LedgerCell.of("column-2", recipe, 1000, 0)]) == (
        [] if found else [LedgerCell.of("column-2", recipe, 1000, 0)]
    )
    assert found or ledger.entries[0].cell.digest == "01234567"


def test_experiments_of_version_0_1_move_into_the_ledger(tmp_path: Path) -> None:
    path = tmp_path / "extrapolation" / "shots-fast-3-28fbb542.json"
    path.parent.mkdir()
    name = {"quantity": "shots", "recipe": "fast", "digest": "28fbb542", "training_seed": 3}
    games = [game._asdict() for game in GAMES]
    path.write_text(json.dumps({"experiment": name, "games": games}))
    Ledger(tmp_path).add(entry())
    path.unlink()
    assert list(Ledger(tmp_path).extrapolations) == [Extrapolation(EXPERIMENT, GAMES)]
    path.write_text("{}")
    with pytest.raises(Invalid, match=r"28fbb542\.json"):
        Ledger(tmp_path)
