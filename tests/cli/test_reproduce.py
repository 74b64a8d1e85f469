"""``tril reproduce``: which runs are taken for results, and for how long it trains."""

from __future__ import annotations

import pytest

from cli.commands.reproduce import _runs_of, cells_of
from cli.workspace import Workspace
from testsupport.workplace import TINY, Workplace
from trainer.reporting.ledger import LedgerCell
from tril.recipes import FAST
from tril.store import behaviours
from tril.store.models import RunStatus
from tril.store.training import runs
from tril.teaching.new_run import create_run

CELL = LedgerCell.of("column-1", TINY, 256, 0)


def example_run(workplace: Workplace, behaviour_id: int, status: RunStatus) -> str:
    """Make a run on scripted demonstrations that ended with a status."""
    with workplace.database.writing() as session:
        row = create_run(session, behaviour_id, TINY, CELL.steps, 0, example=True)
        row.status = status
        return row.id


def runs_of(workplace: Workplace) -> list[str]:
    return _runs_of(Workspace(workplace.settings, workplace.database), {CELL: TINY})


@pytest.mark.parametrize("status", [RunStatus.DONE, RunStatus.QUEUED])
def test_a_run_that_is_there_is_not_started_again(workplace: Workplace, status: RunStatus) -> None:
    run_id = example_run(workplace, workplace.behaviour_id, status)
    assert runs_of(workplace) == [run_id]


def test_each_behaviour_is_trained_for_as_many_steps_as_the_recipe_proposes() -> None:
    cells = cells_of([FAST], ["column-1", "row-1"], [0], None)
    assert [cell.steps for cell in cells] == [FAST.default_steps, FAST.ordered_steps]
    cells = cells_of([FAST], ["column-1", "row-1"], [0], 5_000)
    assert [cell.steps for cell in cells] == [5_000, 5_000]


def test_failed_runs_and_runs_on_other_demonstrations_are_started_again(
    workplace: Workplace,
) -> None:
    others = {
        example_run(workplace, workplace.behaviour_id, RunStatus.FAILED),
        workplace.make_run(TINY, CELL.steps),
    }
    (started,) = runs_of(workplace)
    assert started not in others
    assert workplace.run(started).example


def test_a_run_that_continues_another_is_no_result_of_its_recipe(workplace: Workplace) -> None:
    parent = example_run(workplace, workplace.behaviour_id, RunStatus.DONE)
    child = example_run(workplace, workplace.behaviour_id, RunStatus.DONE)
    with workplace.database.writing() as session:
        runs.get(session, child).parent_run_id = parent
    assert runs_of(workplace) == [parent]


def test_runs_of_deleted_behaviours_are_passed_over(workplace: Workplace) -> None:
    run_id = example_run(workplace, workplace.behaviour_id, RunStatus.DONE)
    with workplace.database.writing() as session:
        own = behaviours.create(session, "My own", target=((0, 0),))
    example_run(workplace, own.id, RunStatus.DONE)
    with workplace.database.writing() as session:
        behaviours.delete(session, behaviours.get(session, own.id))
    assert runs_of(workplace) == [run_id]
