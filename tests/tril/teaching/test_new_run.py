"""New runs: what they may be, and the ranking frozen for them."""

from __future__ import annotations

import pytest

from testsupport.workplace import TINY, Workplace
from tril.analysis.outcome import RunSnapshot
from tril.errors import Conflict, Invalid, NotFound
from tril.recipes import with_values
from tril.store import behaviours, rankings, recordings
from tril.store.models import RunStatus, now
from tril.store.training import artifacts, runs
from tril.teaching.new_run import create_run


def test_a_new_run_is_queued_with_the_ranking_frozen(workplace: Workplace) -> None:
    row = workplace.run(workplace.make_run())
    assert row.status == RunStatus.QUEUED
    assert row.snapshot == RunSnapshot(
        ranking_revision=1,
        tiers=[[number] for number in workplace.ranked],
        perfect=[workplace.ranked[0]],
    )
    with workplace.database.writing() as session:
        recordings.delete(session, [recordings.get(session, workplace.ranked[3])], None)
    assert workplace.run(row.id).snapshot == row.snapshot


def test_fewer_than_two_tiers_are_refused(workplace: Workplace) -> None:
    with workplace.database.writing() as session:
        rankings.save(session, workplace.behaviour_id, 1, [list(workplace.ranked)])
    with pytest.raises(Invalid, match="at least two tiers"):
        workplace.make_run()


def test_the_best_ranked_stand_in_where_none_is_marked_as_perfect(workplace: Workplace) -> None:
    best = workplace.ranked[0]
    with workplace.database.writing() as session:
        recordings.update(session, recordings.get(session, best), perfect=False)
    found = workplace.run(workplace.make_run()).snapshot
    assert found is not None
    assert (found.perfect, found.none_marked) == ([best], True)


def test_a_ranking_whose_recordings_are_deleted_or_unverified_is_refused(
    workplace: Workplace,
) -> None:
    deleted, unverified = workplace.ranked[2:]
    with workplace.database.writing() as session:
        recordings.get(session, deleted).deleted_at = now()
        recordings.get(session, unverified).verification = "failed"
    wrong = f"recording {deleted} has been deleted, recording {unverified} is not verified"
    with pytest.raises(Invalid, match=wrong):
        workplace.make_run()


def test_no_more_runs_than_allowed_may_wait(workplace: Workplace) -> None:
    def create() -> str:
        with workplace.database.writing() as session:
            row = create_run(
                session, workplace.behaviour_id, TINY, 10, 0, example=True, max_queued=2
            )
            return row.id

    first = create()
    create()
    with pytest.raises(Conflict, match="2 runs are waiting already"):
        create()
    with workplace.database.writing() as session:
        runs.get(session, first).status = RunStatus.RUNNING
    create()


def test_an_example_needs_no_ranking_yet(workplace: Workplace) -> None:
    with workplace.database.writing() as session:
        row = create_run(session, workplace.behaviour_id, TINY, 10, 0, example=True)
        assert row.snapshot is None


def with_imitator(workplace: Workplace) -> str:
    """Return a run that has an imitator."""
    run_id = workplace.make_run()
    with workplace.database.writing() as session:
        artifacts.save(session, run_id, "imitator", "imitator.zip", "application/octet-stream", 1)
    return run_id


def test_a_run_continues_from_one_that_has_an_imitator(workplace: Workplace) -> None:
    parent = with_imitator(workplace)
    child = workplace.run(workplace.make_run(parent_run_id=parent))
    assert child.parent_run_id == parent
    assert child.snapshot == workplace.run(parent).snapshot
    assert workplace.run(parent).parent_run_id is None


def test_a_parent_that_can_not_be_continued_is_refused_with_what_to_do(
    workplace: Workplace,
) -> None:
    parent = with_imitator(workplace)
    unfinished = workplace.make_run()
    with pytest.raises(NotFound, match="no such training"):
        workplace.make_run(parent_run_id="missing")
    with pytest.raises(Conflict, match="has no imitator yet"):
        workplace.make_run(parent_run_id=unfinished)
    from_scratch = {"policy.warm_start": False, "policy.freeze_convolutions": False}
    for values in ({"method": "gail"}, from_scratch):
        with pytest.raises(Invalid, match="does not train by PPO with a warm start"):
            workplace.make_run(with_values(TINY, values), parent_run_id=parent)
    other = {
        "policy.network": "nature",
        "cloning.network": "nature",
        "cloning.pretrained": False,
        "cloning.freeze_convolutions": False,
    }
    nature = with_values(TINY, other)
    with pytest.raises(Invalid, match="has the network 'small', but the recipe tiny trains"):
        workplace.make_run(nature, parent_run_id=parent)
    with workplace.database.writing() as session:
        column_2 = behaviours.by_slug(session, "column-2").id
        with pytest.raises(Invalid, match="teaches another behaviour"):
            create_run(session, column_2, TINY, 10, 0, example=True, parent_run_id=parent)
    with workplace.database.writing() as session:
        runs.request_cancel(session, parent)
        runs.delete(session, parent)
    with pytest.raises(NotFound, match="no such training"):
        workplace.make_run(parent_run_id=parent)
