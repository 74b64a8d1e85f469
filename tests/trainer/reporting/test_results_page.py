"""The page of all results, written from the ledger."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from tests.trainer.reporting.entries import entry
from trainer.reporting.ledger import DEVICE, PRECISION, Entry, Ledger
from trainer.reporting.results_page import cell_folder, page_text, write_page
from tril.recipes import FAST, evaluated_on_own_start, with_values

PUBLISHED = Path(__file__).parents[3] / "docs" / "results"
ROW = "| 6 + 0 | 6 + 0 | 5 + 0 | 5 + 1 | 2 + 0 ✗ | 3 + 0 | tie / imitator / clone | float32 |"


def page_of(folder: Path, *entries: Entry) -> str:
    """Return the page of a ledger with these results."""
    ledger = Ledger(folder)
    for one in entries:
        ledger.add(one)
    return page_text(folder)


def rows(page: str, first: str) -> list[list[str]]:
    """Return the cells of the rows whose first cell begins like this."""
    found = [line for line in page.splitlines() if line.startswith(f"| {first}")]
    return [line.strip("| ").split(" | ") for line in found]


def test_the_published_page_is_that_of_the_published_ledger() -> None:
    how = "run tril reproduce --page-only -o docs/results"
    assert page_text(PUBLISHED) == (PUBLISHED / "README.md").read_text(), how


def test_published_results_are_of_the_recipes_as_they_are() -> None:
    assert "(other values" not in page_text(PUBLISHED)


def test_a_recipe_without_a_result_of_this_version_is_named_as_such(tmp_path: Path) -> None:
    remark = "None of these results is of today's `fast`"
    assert remark in page_of(tmp_path, entry(recipe=with_values(FAST, {"policy.n_epochs": 9})))
    assert remark not in page_of(tmp_path, entry())


def test_the_page_says_who_won_and_links_the_pages_that_are_there(tmp_path: Path) -> None:
    Ledger(tmp_path).add(entry(seed=1))
    folder = cell_folder(entry(seed=1))
    (tmp_path / folder).mkdir(parents=True)
    (tmp_path / folder / "README.md").touch()
    page = page_of(tmp_path, entry(seed=0), entry("column-6"))
    assert f"| Column 2 | 1,000 | 0 {ROW}" in page
    assert f"| [Column 2]({folder}/README.md) | 1,000 | 1 {ROW}" in page
    assert page.count("README.md)") == 1
    (means,) = rows(page, "Column 2 | 1,000 | 0, 1 | imitator")
    assert means[4].startswith("3.50 [")
    assert means[7].startswith("50% [")
    assert means[8].startswith("0% [")
    assert means[12:] == ["1.00", "97.0%", "3"]


def test_a_behaviours_pictures_are_of_its_longest_training(tmp_path: Path) -> None:
    six = [entry("column-6", steps=steps) for steps in (9_000, 10_000)]
    page = page_of(tmp_path, *six, entry("column-2"))
    heads = ("Column 2 | 1,000", "Column 6 | 9,000", "Column 6 | 10,000")
    places = [page.index(f"| {head} | 0 | imitator") for head in heads]
    assert places == sorted(places)
    assert "| rank | Column 2 | Column 6 |" in page
    write_page(tmp_path)
    for name in ("aliens-fast.png", "returns-fast.png"):
        assert (tmp_path / name).read_bytes().startswith(b"\x89PNG")


def test_policies_trained_on_their_start_have_a_table_of_their_own(tmp_path: Path) -> None:
    own = [entry(recipe=evaluated_on_own_start(FAST, start)) for start in (0, 2)]
    for one in own:
        (tmp_path / cell_folder(one)).mkdir(parents=True)
        (tmp_path / cell_folder(one) / "README.md").touch()
    held_out, table = page_of(tmp_path, entry(), *own).split("## One imitator per start")
    assert held_out.count(f"| Column 2 | 1,000 | 0 {ROW}") == 1
    ((*cells, pages),) = rows(table, "Column 2")
    assert cells[3:] == ["0", "6 + 0", "6 + 0", "", "", "2 + 0 ✗", "3 + 0", "tie / – / clone"]
    links = [f"[{n}]({cell_folder(one)}/README.md)" for n, one in zip((0, 2), own, strict=True)]
    assert pages == ", ".join(links)


@pytest.mark.parametrize(
    ("changes", "name"),
    [
        ({"policy.n_epochs": 9}, "policy.n_epochs 9"),
        ({}, "other values, {}"),
        ({"policy.n_epochs": 8}, "other values, {}"),
        ({"policy.forgotten": 9}, "other values, {}"),
    ],
)
def test_results_with_other_values_name_them(
    tmp_path: Path, changes: dict[str, int], name: str
) -> None:
    other = entry(recipe=with_values(FAST, {"policy.n_epochs": 9}), changes=changes)
    page = page_of(tmp_path, entry(), other)
    first, second = rows(page, "Column 2")[:2]
    assert (first[0], second[0]) == ("Column 2", f"Column 2 ({name.format(other.cell.digest)})")


def test_results_of_unknown_recipes_and_behaviours_are_left_out(tmp_path: Path) -> None:
    known = entry()
    others = [replace(known.cell, recipe="later"), replace(known.cell, behaviour="column-7")]
    page = page_of(tmp_path, known, *(replace(known, cell=cell) for cell in others))
    assert page.count("| imitator | 3.50 [") == 1


def test_the_page_says_what_a_policy_learned_on(tmp_path: Path) -> None:
    here = entry(versions={PRECISION: "bfloat16", DEVICE: "cpu"})
    on_gpu = entry(seed=1, versions={PRECISION: "bfloat16", DEVICE: "cuda"})
    page = page_of(tmp_path, here, on_gpu)
    assert [row[-1] for row in rows(page, "Column 2")][1:] == ["bfloat16", "bfloat16, GPU"]
