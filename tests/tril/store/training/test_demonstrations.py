"""Which of a run's demonstrations is the best one."""

from __future__ import annotations

import pytest

from testsupport.workplace import Workplace
from tril.store import recordings
from tril.store.models import BehaviourRow, RunRow
from tril.store.training.demonstrations import best_demonstration

COLUMN_1 = [(row, 0) for row in range(6)]


def best(workplace: Workplace, run_id: str) -> int | None:
    with workplace.database.reading() as session:
        row = best_demonstration(session, session.get_one(RunRow, run_id))
        return None if row is None else row.id


def hit(workplace: Workplace, game: int, cells: list[tuple[int, int]]) -> None:
    with workplace.database.writing() as session:
        recordings.get(session, game).taken = [[r, c, 60 * n] for n, (r, c) in enumerate(cells, 1)]


@pytest.mark.parametrize(
    ("hits", "place"),
    [
        ([COLUMN_1[:2], COLUMN_1[:3], [], []], 1),
        ([[*COLUMN_1[:3], (0, 1), (0, 2)], COLUMN_1[:2], [], []], 1),
        ([[], COLUMN_1[:2], COLUMN_1[:2], []], 1),
        ([[], [(0, 1)], [], []], 0),
    ],
    ids=["more targets", "fewer strays", "as many", "none"],
)
def test_it_is_worth_most_wherever_it_is_ranked(
    workplace: Workplace, hits: list[list[tuple[int, int]]], place: int
) -> None:
    for game, cells in zip(workplace.ranked, hits, strict=True):
        hit(workplace, game, cells)
    assert best(workplace, workplace.make_run()) == workplace.ranked[place]


@pytest.mark.parametrize(
    ("perfect", "place"), [([], 0), ([3, 2], 2)], ids=["no best effort", "best efforts"]
)
def test_without_a_target_it_is_a_best_effort_or_at_the_top(
    workplace: Workplace, perfect: list[int], place: int
) -> None:
    run_id = workplace.make_run()
    with workplace.database.writing() as session:
        session.get_one(BehaviourRow, workplace.behaviour_id).target = None
        run = session.get_one(RunRow, run_id)
        assert run.snapshot is not None
        marked = [workplace.ranked[one] for one in perfect]
        run.snapshot = run.snapshot.model_copy(update={"perfect": marked})
    hit(workplace, workplace.ranked[1], COLUMN_1)
    assert best(workplace, run_id) == workplace.ranked[place]


def test_aliens_out_of_order_count_as_strays(workplace: Workplace) -> None:
    run_id = workplace.make_run()
    with workplace.database.writing() as session:
        behaviour = session.get_one(BehaviourRow, workplace.behaviour_id)
        behaviour.target, behaviour.ordered = [[0, column] for column in range(6)], True
    hit(workplace, workplace.ranked[0], [(0, column) for column in (5, 4, 3, 2, 1, 0)])
    hit(workplace, workplace.ranked[2], [(0, column) for column in range(3)])
    assert best(workplace, run_id) == workplace.ranked[2]
