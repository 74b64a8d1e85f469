"""Runs and leases on a migrated database."""

from __future__ import annotations

from datetime import datetime, timedelta, tzinfo

import pytest
from sqlalchemy import update

from testsupport.workplace import TINY, Workplace
from tril.errors import Conflict, NotFound
from tril.recipes import PAPER
from tril.store import processes
from tril.store.models import RunRow, RunStatus, now
from tril.store.training import leases, runs
from tril.store.training.leases import LeaseLost
from tril.teaching.new_run import create_run

VERSIONS = {"python": "3.11"}


def let_heartbeat_age(workplace: Workplace, run_id: str) -> None:
    with workplace.database.writing() as session:
        old = now() - processes.ALIVE_FOR - timedelta(seconds=1)
        session.execute(update(RunRow).where(RunRow.id == run_id).values(heartbeat_at=old))


def test_only_one_worker_gets_a_run(workplace: Workplace) -> None:
    run_id = workplace.make_run()
    with workplace.database.writing() as session:
        lease = leases.acquire(session, run_id, "worker-0")
        assert lease is not None
        leases.keep_versions(session, lease, VERSIONS)
    with workplace.database.writing() as session:
        assert leases.acquire(session, run_id, "worker-1") is None
    assert workplace.run(run_id).worker == "worker-0"
    assert workplace.run(run_id).versions == VERSIONS


def test_a_worker_that_comes_back_leases_its_run_again_and_the_old_lease_is_void(
    workplace: Workplace,
) -> None:
    run_id = workplace.make_run()
    old, new = workplace.lease(run_id), workplace.lease(run_id)
    assert new.epoch == old.epoch + 1
    with pytest.raises(LeaseLost), workplace.database.writing() as session:
        leases.report(session, old, "reward", 0.5, None)
    with workplace.database.writing() as session:
        assert not leases.beat(session, old)
        leases.report(session, new, "reward", 0.25, 10.0)
    assert workplace.run(run_id).stage_done == 0.25


def test_another_worker_gets_a_run_whose_worker_is_not_heard_of(workplace: Workplace) -> None:
    run_id = workplace.make_run()
    workplace.lease(run_id)
    let_heartbeat_age(workplace, run_id)
    assert workplace.lease(run_id, "worker-1").epoch == 2


def test_a_run_that_is_over_is_not_leased(workplace: Workplace) -> None:
    run_id = workplace.make_run()
    with workplace.database.writing() as session:
        runs.request_cancel(session, run_id)
    with workplace.database.writing() as session:
        assert leases.acquire(session, run_id, "worker-0") is None


def test_cancelling_a_queued_run_is_immediate(workplace: Workplace) -> None:
    run_id = workplace.make_run()
    with workplace.database.writing() as session:
        row = runs.request_cancel(session, run_id)
    assert row.status == RunStatus.CANCELLED
    assert row.message == "Cancelled before it began. Resume it to start it."


def test_a_run_that_waits_again_is_cancelled_with_its_checkpoint(workplace: Workplace) -> None:
    run_id = workplace.make_run()
    lease = workplace.lease(run_id)
    with workplace.database.writing() as session:
        leases.release(session, lease)
        assert "last checkpoint" in runs.request_cancel(session, run_id).message


def test_cancelling_asks_a_living_worker_and_does_not_wait_for_a_dead_one(
    workplace: Workplace,
) -> None:
    run_id = workplace.make_run()
    lease = workplace.lease(run_id)
    with workplace.database.writing() as session:
        assert runs.request_cancel(session, run_id).status == RunStatus.CANCELLING
    with workplace.database.reading() as session:
        assert leases.is_cancelling(session, lease)
    other = workplace.make_run()
    lost = workplace.lease(other, "worker-1")
    let_heartbeat_age(workplace, other)
    with workplace.database.writing() as session:
        assert runs.request_cancel(session, other).status == RunStatus.CANCELLED
    with pytest.raises(LeaseLost), workplace.database.writing() as session:
        leases.end(session, lost, RunStatus.DONE)


class ClockAhead(datetime):
    """A machine's clock that is a minute ahead of the others'."""

    @classmethod
    def now(cls, tz: tzinfo | None = None) -> ClockAhead:
        return super().now(tz) + timedelta(minutes=1)


def test_the_clocks_of_processes_need_not_agree(
    workplace: Workplace, monkeypatch: pytest.MonkeyPatch
) -> None:
    run_id = workplace.make_run()
    workplace.lease(run_id)
    with workplace.database.writing() as session:
        processes.beat(session, "worker-0", "worker", {})
    monkeypatch.setattr("tril.store.models.datetime", ClockAhead)
    with workplace.database.writing() as session:
        assert processes.is_kind_alive(session, "worker")
        assert leases.acquire(session, run_id, "worker-1") is None
        assert runs.request_cancel(session, run_id).status == RunStatus.CANCELLING


def test_a_stage_that_fails_while_cancelling_ends_as_cancelled(workplace: Workplace) -> None:
    run_id = workplace.make_run()
    lease = workplace.lease(run_id)
    with workplace.database.writing() as session:
        runs.request_cancel(session, run_id)
        leases.end(session, lease, RunStatus.FAILED, "broken")
    assert workplace.run(run_id).status == RunStatus.CANCELLED


def test_resuming_a_stopped_run_means_to_go_on_anyway(workplace: Workplace) -> None:
    with workplace.database.writing() as session:
        run_id = create_run(session, workplace.behaviour_id, TINY, 10, 0).id
    lease = workplace.lease(run_id)
    with workplace.database.writing() as session:
        leases.end(session, lease, RunStatus.STOPPED, "confused")
    with workplace.database.writing() as session:
        row = runs.queue_again(session, run_id)
        assert row.status == RunStatus.QUEUED
        assert row.go_on_anyway
        assert row.message == ""


def test_a_run_that_is_not_over_or_done_is_not_resumed(workplace: Workplace) -> None:
    run_id = workplace.make_run()
    with pytest.raises(Conflict, match="not over"), workplace.database.writing() as session:
        runs.queue_again(session, run_id)
    lease = workplace.lease(run_id)
    with workplace.database.writing() as session:
        leases.end(session, lease, RunStatus.DONE)
    with pytest.raises(Conflict, match="is done"), workplace.database.writing() as session:
        runs.queue_again(session, run_id)
    with pytest.raises(Conflict, match="already over"), workplace.database.writing() as session:
        runs.request_cancel(session, run_id)


@pytest.mark.parametrize(
    "former", [{"method": "dagger"}, {"reward": PAPER.to_dict()["reward"] | {"method": "fast"}}]
)
def test_a_run_by_a_method_of_before_is_refused_at_once(
    workplace: Workplace, former: dict[str, object]
) -> None:
    run_id = workplace.make_run()
    lease = workplace.lease(run_id)
    with workplace.database.writing() as session:
        leases.end(session, lease, RunStatus.FAILED, "broken")
        row = runs.get(session, run_id)
        row.recipe = row.recipe | former
    with (
        pytest.raises(Conflict, match="does not have any more"),
        workplace.database.writing() as session,
    ):
        runs.queue_again(session, run_id)
    assert workplace.run(run_id).status == RunStatus.FAILED


def test_deleting_waits_for_the_end_and_hides_the_run(workplace: Workplace) -> None:
    run_id = workplace.make_run()
    with pytest.raises(Conflict, match="Cancel it first"), workplace.database.writing() as session:
        runs.delete(session, run_id)
    with workplace.database.writing() as session:
        runs.request_cancel(session, run_id)
        runs.delete(session, run_id)
        assert runs.listing(session) == []
        assert leases.acquire(session, run_id, "worker-0") is None
    with pytest.raises(NotFound):
        workplace.run(run_id)


def test_a_run_given_back_waits_again(workplace: Workplace) -> None:
    run_id = workplace.make_run()
    lease = workplace.lease(run_id)
    with workplace.database.writing() as session:
        leases.finish_stage(session, lease, "trajectories", 1.5)
        leases.release(session, lease)
    row = workplace.run(run_id)
    assert row.status == RunStatus.QUEUED
    assert row.finished_stages == {"trajectories": 1.5}
    with pytest.raises(LeaseLost), workplace.database.writing() as session:
        leases.finish_stage(session, lease, "reward", 1.0)
