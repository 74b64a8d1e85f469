"""The ledger of finished results, this version's and that of 0.1.0."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest

from tests.trainer.reporting.entries import entry
from testsupport.workplace import Workplace
from trainer.reporting import digests
from trainer.reporting.digests import recipe_digest
from trainer.reporting.ledger import Ledger
from trainer.reporting.run_entry import read_entry
from tril.errors import Invalid
from tril.recipes import FAST, PAPER, with_values
from tril.store.models import RunStatus, now
from tril.store.training import runs


def test_added_results_are_read_back_and_no_longer_missing(tmp_path: Path) -> None:
    first, second = entry(seed=0), entry(seed=1)
    ledger = Ledger(tmp_path)
    assert ledger.missing([first.cell, second.cell]) == [first.cell, second.cell]
    ledger.add(first)
    again = Ledger(tmp_path)
    assert list(again.entries) == [first]
    assert again.missing([first.cell, second.cell]) == [second.cell]
    changed = replace(first, check={})
    again.add(changed)
    assert list(Ledger(tmp_path).entries) == [changed]
    lines = [json.loads(line) for line in again.path.read_text().splitlines()]
    assert [line["version"] for line in lines] == [2]


def test_a_sanity_experiment_of_an_earlier_version_is_passed_over(tmp_path: Path) -> None:
    ledger = Ledger(tmp_path)
    ledger.add(entry())
    with ledger.path.open("a") as file:
        file.write('{"version": 2, "experiment": {"quantity": "shots"}, "games": []}\n')
    assert [*Ledger(tmp_path).entries] == [entry()]


@pytest.mark.parametrize("line", ['{"cell": {}}', "[]", "{", '{"version": 3, "cell": {}}'])
def test_a_line_that_is_no_result_is_named(tmp_path: Path, line: str) -> None:
    ledger = Ledger(tmp_path)
    ledger.add(entry())
    with ledger.path.open("a") as file:
        file.write(f"{line}\n")
    with pytest.raises(Invalid, match=r"Line 2 of .*ledger\.jsonl"):
        Ledger(tmp_path)


def test_the_digest_changes_with_values_and_not_with_words() -> None:
    assert recipe_digest(FAST) != recipe_digest(PAPER)
    assert recipe_digest(with_values(FAST, {"policy.n_epochs": 9})) != recipe_digest(FAST)
    reworded = replace(FAST, summary="In other words.", default_steps=1)
    assert recipe_digest(reworded) == recipe_digest(FAST)


def test_the_digest_changes_with_the_pretrained_weights_that_a_recipe_begins_with(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    before = {recipe: recipe_digest(recipe) for recipe in (FAST, PAPER)}
    other = tmp_path / "other.safetensors"
    other.write_bytes(b"other weights")
    monkeypatch.setattr(digests, "PRETRAINED", other)
    assert recipe_digest(FAST) != before[FAST]
    assert recipe_digest(PAPER) == before[PAPER]
    assert recipe_digest(FAST.reward) != recipe_digest(PAPER.reward)


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
