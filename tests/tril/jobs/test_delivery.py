"""The run's row and its job stay in step, whatever crashes in between."""

from __future__ import annotations

import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from datetime import timedelta
from types import SimpleNamespace

import pytest
from dbos import DBOSClient
from sqlalchemy import text, update

from testsupport.waiting import wait_until
from testsupport.workplace import Workplace
from tril.errors import Conflict
from tril.jobs import Jobs, delivery
from tril.jobs.delivery import GIVEN_UP, RECONCILE_EVERY_S
from tril.jobs.queue import QUEUES, open_client
from tril.settings import Settings
from tril.store.database import create_database
from tril.store.models import ProcessRow, RunDevice, RunRow, RunStatus
from tril.store.training import leases, runs

LOST_AFTER_S = 1.0


@pytest.fixture
def jobs(workplace: Workplace) -> Iterator[Jobs]:
    made = Jobs(workplace.database, workplace.settings, lost_after_s=LOST_AFTER_S)
    yield made
    made.close()


@pytest.fixture
def queue(workplace: Workplace) -> Iterator[DBOSClient]:
    client = open_client(workplace.settings)
    yield client
    client.destroy()


@contextmanager
def idle_worker(workplace: Workplace, name: str) -> Iterator[subprocess.Popen[str]]:
    with subprocess.Popen(
        [sys.executable, "-m", "tests.tril.jobs.idle_worker", str(workplace.settings.data), name],
        stdout=subprocess.PIPE,
        text=True,
    ) as process:
        yield process
        process.kill()


def said(process: subprocess.Popen[str]) -> str:
    assert process.stdout is not None
    return process.stdout.readline().strip()


def until(jobs: Jobs, holds: Callable[[], bool]) -> None:
    def reconciled() -> bool:
        jobs.reconcile()
        return holds()

    wait_until(reconciled)


def job_status(queue: DBOSClient, run_id: str) -> str | None:
    found = queue.list_workflows(workflow_ids=[run_id])
    return found[0].status if found else None


def give_up_all(settings: Settings) -> None:
    """Do to every job what the queue does to one that it has delivered too often."""
    database = create_database(settings.queue_url)
    table = "workflow_status" if "sqlite" in settings.queue_url else "dbos.workflow_status"
    with database.engine.begin() as connection:
        connection.execute(
            text(f"UPDATE {table} SET status = :status, queue_name = NULL"), {"status": GIVEN_UP}
        )
    database.close()


def test_a_run_is_enqueued_once_under_its_own_id(
    workplace: Workplace, jobs: Jobs, queue: DBOSClient
) -> None:
    run_id = workplace.make_run()
    jobs.enqueue(run_id)
    jobs.enqueue(run_id)
    jobs.reconcile()
    (job,) = queue.list_workflows()
    assert (job.workflow_id, job.status) == (run_id, "ENQUEUED")
    assert job.input == {"args": (run_id,), "kwargs": {}}


def test_a_run_for_a_gpu_has_a_queue_of_its_own_also_when_it_is_resumed(
    workplace: Workplace, jobs: Jobs, queue: DBOSClient
) -> None:
    run_id = workplace.make_run(device=RunDevice.GPU)
    jobs.enqueue(run_id)
    assert queue.list_workflows()[0].queue_name == QUEUES[RunDevice.GPU]
    jobs.cancel(run_id)
    jobs.resume(run_id)
    (job,) = queue.list_workflows()
    assert (job.status, job.queue_name) == ("ENQUEUED", QUEUES[RunDevice.GPU])


def test_a_crash_between_the_row_and_its_job_is_repaired(
    workplace: Workplace, jobs: Jobs, queue: DBOSClient
) -> None:
    run_id = workplace.make_run()
    assert job_status(queue, run_id) is None
    jobs.reconcile()
    assert job_status(queue, run_id) == "ENQUEUED"


def test_a_crash_between_resuming_and_the_job_is_repaired(
    workplace: Workplace, jobs: Jobs, queue: DBOSClient
) -> None:
    run_id = workplace.make_run()
    jobs.enqueue(run_id)
    jobs.cancel(run_id)
    assert job_status(queue, run_id) == "CANCELLED"
    with workplace.database.writing() as session:
        runs.queue_again(session, run_id)
    jobs.reconcile()
    assert job_status(queue, run_id) == "ENQUEUED"


def test_a_crash_between_cancelling_and_the_job_leaves_a_job_with_nothing_to_do(
    workplace: Workplace, jobs: Jobs
) -> None:
    run_id = workplace.make_run()
    jobs.enqueue(run_id)
    with workplace.database.writing() as session:
        runs.request_cancel(session, run_id)
    with idle_worker(workplace, "worker-0") as process:
        assert said(process) == f"nothing to do {run_id}"
    assert workplace.run(run_id).status == RunStatus.CANCELLED


def test_an_unreachable_queue_loses_nothing(workplace: Workplace, queue: DBOSClient) -> None:
    elsewhere = workplace.settings.model_copy(
        update={"jobs_database_url": f"sqlite:///{workplace.settings.data / 'not-there.sqlite'}"}
    )
    cut_off = Jobs(workplace.database, elsewhere)
    run_id = workplace.make_run()
    cut_off.enqueue(run_id)
    cut_off.close()
    assert workplace.run(run_id).status == RunStatus.QUEUED
    jobs = Jobs(workplace.database, workplace.settings)
    jobs.reconcile()
    jobs.close()
    assert job_status(queue, run_id) == "ENQUEUED"


def test_a_run_whose_worker_is_gone_passes_to_another(workplace: Workplace, jobs: Jobs) -> None:
    run_id = workplace.make_run()
    jobs.enqueue(run_id)
    with idle_worker(workplace, "worker-0") as process:
        assert said(process) == f"leased {run_id}"
        old = leases.Lease(run_id, "worker-0", workplace.run(run_id).epoch)
    with idle_worker(workplace, "worker-1") as process:
        jobs.reconcile()
        assert workplace.run(run_id).worker == "worker-0"
        until(jobs, lambda: workplace.run(run_id).worker == "worker-1")
        assert said(process) == f"leased {run_id}"
    with pytest.raises(leases.LeaseLost), workplace.database.writing() as session:
        leases.report(session, old, "reward", 0.5, None)


def test_a_worker_that_lives_keeps_its_run(workplace: Workplace, jobs: Jobs) -> None:
    run_id = workplace.make_run()
    jobs.enqueue(run_id)
    with idle_worker(workplace, "worker-0") as process:
        assert said(process) == f"leased {run_id}"
        lease = leases.Lease(run_id, "worker-0", workplace.run(run_id).epoch)
        end = time.monotonic() + 2.5 * LOST_AFTER_S
        while time.monotonic() < end:
            with workplace.database.writing() as session:
                assert leases.beat(session, lease)
            jobs.reconcile()
            time.sleep(0.1)
        assert workplace.run(run_id).epoch == lease.epoch


def silence(workplace: Workplace, worker: str, **identity: str) -> None:
    """Let the last heartbeat of a worker be long ago; say who it is."""
    with workplace.database.writing() as session:
        row = session.get_one(ProcessRow, worker)
        long_ago = row.heartbeat_at - timedelta(minutes=10)
        session.execute(
            update(ProcessRow)
            .where(ProcessRow.name == worker)
            .values(heartbeat_at=long_ago, **identity)
        )


def reconcile_for(jobs: Jobs, seconds: float) -> None:
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        jobs.reconcile()
        time.sleep(0.1)


def test_a_worker_that_is_starved_but_lives_on_this_machine_keeps_its_run(
    workplace: Workplace, jobs: Jobs
) -> None:
    run_id = workplace.make_run()
    jobs.enqueue(run_id)
    with idle_worker(workplace, "worker-0") as process:
        assert said(process) == f"leased {run_id}"
        process.send_signal(signal.SIGSTOP)
        silence(workplace, "worker-0")
        reconcile_for(jobs, 2.5 * LOST_AFTER_S)
        row = workplace.run(run_id)
        assert (row.status, row.worker, row.epoch) == (RunStatus.RUNNING, "worker-0", 1)
        # However patient, a person may end it; what the worker still writes is refused.
        with workplace.database.writing() as session:
            session.get_one(RunRow, run_id).heartbeat_at = None
        jobs.cancel(run_id)
        assert workplace.run(run_id).status == RunStatus.CANCELLED
        process.kill()


@pytest.mark.parametrize("identity", [{"machine": "another"}, {"started": "1"}])
def test_a_silent_worker_elsewhere_or_whose_id_is_anothers_by_now_loses_its_run(
    workplace: Workplace, jobs: Jobs, identity: dict[str, str]
) -> None:
    run_id = workplace.make_run()
    jobs.enqueue(run_id)
    with idle_worker(workplace, "worker-0") as process:
        assert said(process) == f"leased {run_id}"
        process.send_signal(signal.SIGSTOP)
        silence(workplace, "worker-0", **identity)
        until(jobs, lambda: workplace.run(run_id).status == RunStatus.QUEUED)
        process.kill()


def test_a_worker_that_lives_and_no_longer_names_the_run_loses_it(
    workplace: Workplace, jobs: Jobs
) -> None:
    run_id = workplace.make_run()
    jobs.enqueue(run_id)
    with idle_worker(workplace, "worker-0") as process:
        assert said(process) == f"leased {run_id}"
        # Its heartbeat is fresh.
        until(jobs, lambda: workplace.run(run_id).status == RunStatus.QUEUED)
        process.kill()


def test_a_job_that_a_starved_worker_has_not_begun_yet_stays_its(
    workplace: Workplace, jobs: Jobs, queue: DBOSClient
) -> None:
    run_id = workplace.make_run()
    jobs.enqueue(run_id)
    with idle_worker(workplace, "worker-0") as process:
        assert said(process) == f"leased {run_id}"
        process.send_signal(signal.SIGSTOP)
        silence(workplace, "worker-0")
        with workplace.database.writing() as session:
            session.get_one(RunRow, run_id).status = RunStatus.QUEUED
        reconcile_for(jobs, 2.5 * LOST_AFTER_S)
        assert job_status(queue, run_id) == "PENDING"
        process.kill()


def test_a_watcher_that_was_suspended_itself_revokes_nothing(
    workplace: Workplace, jobs: Jobs, monkeypatch: pytest.MonkeyPatch
) -> None:
    patient = Jobs(workplace.database, workplace.settings)
    clock_s = 0.0
    monkeypatch.setattr(delivery, "time", SimpleNamespace(monotonic=lambda: clock_s))
    run_id = workplace.make_run()
    workplace.lease(run_id)
    patient.reconcile()
    # Two looks, ten minutes apart.
    clock_s += 600.0
    patient.reconcile()
    assert workplace.run(run_id).status == RunStatus.RUNNING
    while workplace.run(run_id).status == RunStatus.RUNNING:
        clock_s += RECONCILE_EVERY_S
        patient.reconcile()
    assert clock_s == pytest.approx(600.0 + delivery.LOST_AFTER_S - delivery.MAX_WATCHED_S)
    patient.close()


def test_patience_grows_with_every_lease_that_was_lost(
    workplace: Workplace, monkeypatch: pytest.MonkeyPatch
) -> None:
    patient = Jobs(workplace.database, workplace.settings)
    clock_s = 0.0
    monkeypatch.setattr(delivery, "time", SimpleNamespace(monotonic=lambda: clock_s))
    run_id = workplace.make_run()
    took_s = []
    for _ in range(7):
        workplace.lease(run_id)
        patient.reconcile()
        leased_at_s = clock_s
        while workplace.run(run_id).status == RunStatus.RUNNING:
            clock_s += RECONCILE_EVERY_S
            patient.reconcile()
        took_s.append(clock_s - leased_at_s)
    assert took_s == [30.0, 60.0, 120.0, 240.0, 480.0, 480.0, 480.0]
    patient.close()


def test_cancelling_the_run_of_a_worker_that_is_gone_ends_it(
    workplace: Workplace, jobs: Jobs, queue: DBOSClient
) -> None:
    run_id = workplace.make_run()
    jobs.enqueue(run_id)
    with idle_worker(workplace, "worker-0") as process:
        said(process)
    jobs.cancel(run_id)
    until(jobs, lambda: workplace.run(run_id).status == RunStatus.CANCELLED)
    jobs.resume(run_id)
    until(jobs, lambda: job_status(queue, run_id) == "ENQUEUED")


def test_a_done_run_is_neither_cancelled_nor_resumed(workplace: Workplace, jobs: Jobs) -> None:
    run_id = workplace.make_run()
    lease = workplace.lease(run_id)
    with workplace.database.writing() as session:
        leases.end(session, lease, RunStatus.DONE)
    with pytest.raises(Conflict):
        jobs.cancel(run_id)
    with pytest.raises(Conflict):
        jobs.resume(run_id)


def test_a_run_that_the_queue_gave_up_fails_with_a_reason_and_can_be_resumed(
    workplace: Workplace, jobs: Jobs, queue: DBOSClient
) -> None:
    run_id = workplace.make_run()
    jobs.enqueue(run_id)
    workplace.lease(run_id)
    give_up_all(workplace.settings)
    jobs.reconcile()
    row = workplace.run(run_id)
    assert row.status == RunStatus.FAILED
    assert "died each time" in row.message
    jobs.resume(run_id)
    assert job_status(queue, run_id) == "ENQUEUED"


def test_reconciling_in_the_background_repairs_without_being_asked(
    workplace: Workplace, jobs: Jobs, queue: DBOSClient
) -> None:
    jobs.start_reconciling(every_s=0.05)
    run_id = workplace.make_run()
    wait_until(lambda: job_status(queue, run_id) == "ENQUEUED")


def test_an_error_in_the_repair_of_one_run_does_not_stop_the_others(
    workplace: Workplace, queue: DBOSClient, monkeypatch: pytest.MonkeyPatch
) -> None:
    broken, waiting = workplace.make_run(), workplace.make_run()
    deliver = Jobs._deliver

    def fail_at_one(self: Jobs, run_id: str, device: RunDevice) -> None:
        if run_id == broken:
            raise RuntimeError("unexpected")
        deliver(self, run_id, device)

    monkeypatch.setattr(Jobs, "_deliver", fail_at_one)
    jobs = Jobs(workplace.database, workplace.settings)
    jobs.start_reconciling(every_s=0.02)
    wait_until(lambda: job_status(queue, waiting) == "ENQUEUED")
    monkeypatch.setattr(Jobs, "_deliver", deliver)
    wait_until(lambda: job_status(queue, broken) == "ENQUEUED")
    jobs.close()
