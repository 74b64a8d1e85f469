"""The ledger of finished results and the page made from it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from testsupport.workplace import Workplace
from trainer.reporting.ledger import (
    DEVICE,
    PRECISION,
    Cell,
    Entry,
    Ledger,
    LedgerDemonstration,
    LedgerGame,
    read_entry,
    recipe_digest,
)
from trainer.reporting.results_page import cell_folder, write_page
from tril.analysis.summary import GameFigures
from tril.errors import Invalid
from tril.recipes import ABLATIONS, FAST, PAPER, judged_where_trained, with_values
from tril.store.models import RunStatus, now
from tril.store.training import runs


def game(policy: str, start: int, targets: int, strays: int, *, hit: bool = False) -> LedgerGame:
    figures = GameFigures(targets, strays, 0, 300, hit, 12.5)
    cells = tuple((row, 1) for row in range(targets)) + tuple((row, 0) for row in range(strays))
    return LedgerGame(policy, "greedy", start, held_out=start > 0, hits=cells, figures=figures)


def entry(behaviour: str = "column-2", seed: int = 0, steps: int = 1000) -> Entry:
    return Entry(
        cell=Cell.of(behaviour, FAST, steps, seed),
        finished_at="2026-01-02T03:04:05+00:00",
        seconds={"demonstrations": 600.0, "reward": 60.0, "imitator": 120.0},
        check={"tau": 1.0, "pair_accuracy": 0.99, "held_out_accuracy": 0.97},
        demonstrations=(
            LedgerDemonstration(1, ((0, 1), (1, 1)), 20.0),
            LedgerDemonstration(2, ((0, 0),), -3.0),
        ),
        games=(
            game("imitator", 0, 6, 0),
            game("clone", 0, 6, 0),
            game("imitator", 1, 5, 0),
            game("clone", 1, 5, 1),
            game("imitator", 2, 2, 0, hit=True),
            game("clone", 2, 3, 0),
        ),
        versions={"python": "3.11"},
    )


def test_what_is_added_is_read_back_and_no_longer_missing(tmp_path: Path) -> None:
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


def test_policies_judged_where_they_were_trained_have_a_table_of_their_own(tmp_path: Path) -> None:
    ledger = Ledger(tmp_path)
    ledger.add(entry())
    for start in (0, 2):
        cell = Cell.of("column-2", judged_where_trained(FAST, start), 1000, 0)
        ledger.add(replace(entry(), cell=cell))
    assert Ledger(tmp_path).entries == ledger.entries
    held_out, own = write_page(tmp_path, "tril reproduce").read_text().split("## One imitator per")
    assert held_out.count("| Column 2 | 1,000 | 0 | 6 + 0 | 6 + 0 | 5 + 0 |") == 1
    row = "| Column 2 | fast | 1,000 | 0 | 6 + 0 | 6 + 0 |  |  | 2 + 0 ✗ | 3 + 0 | tie /  / clone |"
    assert row in own
    assert own.count("/README.md)") == 2


def test_a_line_that_is_no_result_is_named(tmp_path: Path) -> None:
    ledger = Ledger(tmp_path)
    ledger.add(entry())
    with ledger.path.open("a") as file:
        file.write('{"cell": {}}\n')
    with pytest.raises(Invalid, match=r"Line 2 of .*ledger\.jsonl"):
        Ledger(tmp_path)


def test_a_cell_is_another_when_a_value_of_its_recipe_is() -> None:
    assert recipe_digest(FAST) != recipe_digest(PAPER)
    assert recipe_digest(with_values(FAST, {"policy.n_epochs": 9})) != recipe_digest(FAST)
    reworded = replace(FAST, summary="In other words.", default_steps=1)
    assert recipe_digest(reworded) == recipe_digest(FAST)


def test_minutes_leave_out_what_a_person_would_have_played() -> None:
    assert entry().minutes == 3.0


def test_the_headline_is_of_held_out_games() -> None:
    summary = entry().headline("imitator")
    assert summary is not None
    assert summary.targets is not None
    assert summary.targets.mean == 3.5
    assert summary.targets.n == 2
    assert summary.death_rate.mean == 0.5
    assert entry().headline("imitator", "sampled") is None


def test_the_page_says_who_won_and_links_each_run(tmp_path: Path) -> None:
    ledger = Ledger(tmp_path)
    ledger.add(entry(seed=0))
    ledger.add(entry(seed=1))
    ledger.add(entry("column-6"))
    page = write_page(tmp_path, "tril reproduce").read_text()
    assert "| Column 2 | 1,000 | 0 | 6 + 0 | 6 + 0 | 5 + 0 | 5 + 1 | 2 + 0 ✗ | 3 + 0 |" in page
    assert "tie / imitator / clone" in page
    assert "| Column 2 | 1,000 | 0, 1 | imitator | 3.50 [" in page
    assert f"({cell_folder(entry(seed=1))}/README.md)" in page
    assert (tmp_path / "aliens-fast.png").read_bytes().startswith(b"\x89PNG")
    assert (tmp_path / "returns-fast.png").read_bytes().startswith(b"\x89PNG")


def test_the_page_shows_all_steps_of_a_behaviour_and_pictures_of_the_most(tmp_path: Path) -> None:
    ledger = Ledger(tmp_path)
    for steps in (9_000, 10_000):
        ledger.add(entry("column-6", steps=steps))
    ledger.add(entry("column-2"))
    page = write_page(tmp_path, "tril reproduce").read_text()
    heads = ("Column 2 | 1,000", "Column 6 | 9,000", "Column 6 | 10,000")
    places = [page.index(f"| {head} | 0 | imitator") for head in heads]
    assert places == sorted(places)
    assert "| rank | Column 2 | Column 6 |" in page


def test_other_demonstrations_stand_beside_the_ordinary_ones(tmp_path: Path) -> None:
    ledger = Ledger(tmp_path)
    ordinary = entry("row-1")
    for kind in ("no-wrong", "human", "six"):
        cell = Cell.of("row-1", FAST, 1000, 0, kind)
        ledger.add(replace(ordinary, cell=cell, games=(game("imitator", 1, 4, 1),)))
    assert "| `scripted` |" not in write_page(tmp_path, "tril reproduce").read_text()
    ledger.add(ordinary)
    ledger.add(entry("row-1", steps=2000))
    assert Ledger(tmp_path).entries == ledger.entries
    head, others = (
        write_page(tmp_path, "tril reproduce").read_text().split("## Other demonstrations")
    )
    assert head.count("| Row 1 | 1,000 | 0 | imitator | 3.50 [") == 1
    assert "4.00 [4.00, 4.00]" not in head
    rows = [line for line in others.splitlines() if line.startswith("| Row 1 |")]
    assert [row.split(" | ")[3] for row in rows] == [
        "`scripted`",
        "`human`",
        "`six`",
        "`no-wrong`",
    ]
    assert "| 4.00 [4.00, 4.00] | 1.00 [1.00, 1.00] | 0% [0%, 0%] |" in rows[1]
    folders = {cell_folder(one) for one in ledger.entries}
    assert len(folders) == len(ledger.entries)


def test_what_a_factor_is_worth_stands_beside_the_whole_recipe(tmp_path: Path) -> None:
    ledger = Ledger(tmp_path)
    for one in ABLATIONS:
        cell = Cell.of("column-2", one.recipe, 1000, 0)
        ledger.add(replace(entry(), cell=cell, games=(game("imitator", 1, 1, 0),)))
    ledger.add(entry())
    ledger.add(entry("column-5"))
    head, without = write_page(tmp_path, "tril reproduce").read_text().split("without its parts")
    assert head.count("| Column 2 | 1,000 | 0 | imitator | 3.50 [") == 1
    rows = [line for line in without.splitlines() if line.startswith("| Column ")]
    assert [row.split(" | ")[2] for row in rows] == [
        "(the whole recipe)",
        *(one.name for one in ABLATIONS),
    ]


def test_results_of_other_values_and_other_numbers_are_told_apart(tmp_path: Path) -> None:
    ledger = Ledger(tmp_path)
    changed = with_values(FAST, {"policy.n_epochs": 9})
    other = replace(entry(), cell=Cell.of("column-2", changed, 9000, 0))
    ledger.add(other)
    ledger.add(replace(entry(), versions={PRECISION: "bfloat16", DEVICE: "cpu"}))
    ledger.add(replace(entry(seed=1), versions={PRECISION: "bfloat16", DEVICE: "cuda"}))
    page = write_page(tmp_path, "tril reproduce").read_text()
    assert f"| Column 2 (other values, {other.cell.digest}) | 9,000 | 0 | imitator |" in page
    ledger.add(replace(other, changes={"policy.n_epochs": 9}))
    page = write_page(tmp_path, "tril reproduce").read_text()
    assert "| Column 2 (policy.n_epochs 9) | 9,000 | 0 | imitator |" in page
    for outdated in ({"policy.n_epochs": 8}, {"policy.forgotten": 9}):
        ledger.add(replace(other, changes=outdated))
        page = write_page(tmp_path, "tril reproduce").read_text()
        assert f"| Column 2 (other values, {other.cell.digest}) |" in page
    here, on_gpu = [line for line in page.splitlines() if "learned in bfloat16" in line]
    assert here.startswith("- [Column 2, 1,000 steps")
    assert here.endswith("learned in bfloat16")
    assert on_gpu.endswith("learned in bfloat16, on a GPU")


@pytest.mark.parametrize("status", [RunStatus.CANCELLED, RunStatus.STOPPED, RunStatus.FAILED])
def test_only_a_run_that_is_done_is_a_result(workplace: Workplace, status: RunStatus) -> None:
    run_id = workplace.make_run()
    with workplace.database.writing() as session:
        row = runs.get(session, run_id)
        row.status, row.finished_at = status, now()
    with pytest.raises(Invalid, match=f"{run_id} is {status}"):
        read_entry(workplace.database, run_id)
