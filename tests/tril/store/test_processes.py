"""Which processes count as alive."""

from __future__ import annotations

import os
import subprocess
import threading
from dataclasses import replace
from datetime import timedelta

import pytest
from sqlalchemy import update
from sqlalchemy.orm import Session

from testsupport.waiting import PATIENCE_S
from testsupport.workplace import Workplace
from tril.heartbeat import Heartbeat
from tril.store import processes
from tril.store.models import ProcessRow
from tril.store.processes import ProcessIdentity


def alive(workplace: Workplace) -> set[str]:
    with workplace.database.reading() as session:
        return {one.name for one in processes.statuses(session) if one.alive}


def test_a_process_of_this_machine_is_not_alive_as_soon_as_it_is_killed(
    workplace: Workplace,
) -> None:
    with subprocess.Popen(["sleep", "600"]) as killed, subprocess.Popen(["sleep", "600"]) as other:
        with workplace.database.writing() as session:
            for name, process in (("killed", killed), ("other", other)):
                identity = ProcessIdentity.of(process.pid)
                processes.beat(session, name, "worker", {}, identity)
        killed.kill()
        # Nobody has waited for it yet: its id is still taken.
        while "killed" in alive(workplace):
            pass
        assert alive(workplace) == {"other"}
        killed.wait()
        assert alive(workplace) == {"other"}
        other.kill()


def test_another_process_with_the_same_id_is_not_taken_for_the_one_that_ended(
    workplace: Workplace,
) -> None:
    with subprocess.Popen(["sleep", "600"]) as process:
        later = ProcessIdentity.of(process.pid)
        with workplace.database.writing() as session:
            earlier = replace(later, started="1")
            processes.beat(session, "earlier", "worker", {}, earlier)
        assert alive(workplace) == set()
        process.kill()


def test_a_process_of_another_machine_is_alive_while_its_heartbeat_is_fresh(
    workplace: Workplace,
) -> None:
    elsewhere = ProcessIdentity("another machine", 2**22, "5")
    with workplace.database.writing() as session:
        processes.beat(session, "worker-0", "worker", {}, elsewhere)
    assert alive(workplace) == {"worker-0"}
    with workplace.database.writing() as session:
        row = session.get_one(ProcessRow, "worker-0")
        old = row.heartbeat_at - processes.ALIVE_FOR
        session.execute(update(ProcessRow).values(heartbeat_at=old))
    assert alive(workplace) == set()


def test_a_process_of_this_machine_is_busy_while_it_lives_without_a_heartbeat(
    workplace: Workplace,
) -> None:
    with subprocess.Popen(["sleep", "600"]) as starved:
        identity = ProcessIdentity.of(starved.pid)
        with workplace.database.writing() as session:
            processes.beat(session, "starved", "worker", {}, identity)
            processes.beat(session, "later", "worker", {}, replace(identity, started="1"))
            processes.beat(
                session, "inside", "worker", {}, replace(identity, machine="a container")
            )
            old = session.get_one(ProcessRow, "starved").heartbeat_at - processes.ALIVE_FOR
            session.execute(update(ProcessRow).values(heartbeat_at=old))
        with workplace.database.reading() as session:
            found = {one.name: (one.alive, one.busy) for one in processes.statuses(session)}
        assert found == {
            "starved": (True, True), "later": (False, False), "inside": (False, False),
        }  # fmt: skip
        starved.kill()


def test_a_process_that_hides_when_it_started_is_not_taken_for_ended(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    identity = ProcessIdentity.of(os.getpid())
    # As /proc with the option hidepid does for the processes of other users.
    monkeypatch.setattr(processes, "_started", lambda pid: "")
    assert not identity.has_ended
    assert not identity.is_running


def test_a_heartbeat_of_before_the_clock_was_set_back_does_not_count(workplace: Workplace) -> None:
    elsewhere = ProcessIdentity("another machine", 2**22, "5")
    with workplace.database.writing() as session:
        processes.beat(session, "worker-0", "worker", {}, elsewhere)
        later = session.get_one(ProcessRow, "worker-0").heartbeat_at + timedelta(hours=1)
        session.execute(update(ProcessRow).values(heartbeat_at=later))
    assert alive(workplace) == set()


def test_a_process_that_was_replaced_is_listed_for_a_few_minutes_only(
    workplace: Workplace,
) -> None:
    def listed() -> set[str]:
        with workplace.database.reading() as session:
            return {one.name for one in processes.statuses(session)}

    with subprocess.Popen(["sleep", "600"]) as later:
        here = ProcessIdentity.of(later.pid)
        killed = replace(here, started="1")
        with workplace.database.writing() as session:
            processes.beat(session, "killed", "server", {}, killed)
            processes.beat(session, "worker", "worker", {}, killed)
            processes.beat(session, "elsewhere", "server", {}, replace(killed, machine="another"))
            heard = session.get_one(ProcessRow, "killed").heartbeat_at
            old = heard - processes.REPLACED_AFTER
            session.execute(update(ProcessRow).values(heartbeat_at=old))
        assert listed() == {"killed", "worker", "elsewhere"}
        with workplace.database.writing() as session:
            processes.beat(session, "recent", "server", {}, killed)
            processes.beat(session, "later", "server", {}, here)
        assert listed() == {"worker", "elsewhere", "recent", "later"}
        assert alive(workplace) == {"later"}
        later.kill()


def test_a_process_is_not_replaced_by_one_that_ran_beside_it(
    workplace: Workplace, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(processes, "REPLACED_AFTER", timedelta(0))
    beside = ProcessIdentity.of(os.getpid())
    with workplace.database.writing() as session:
        processes.beat(session, "beside", "worker", {}, beside)
        processes.beat(session, "killed", "worker", {}, replace(beside, started="1"))
    with workplace.database.reading() as session:
        states = {one.name: one.alive for one in processes.statuses(session)}
    assert states == {"beside": True, "killed": False}


def test_a_heartbeat_goes_on_after_an_unexpected_error(
    workplace: Workplace, caplog: pytest.LogCaptureFixture
) -> None:
    beats = threading.Semaphore(0)

    def fail(session: Session) -> None:
        beats.release()
        raise KeyError("unexpected")

    with Heartbeat(workplace.database, "worker-0", "worker", also=fail, interval_s=0.01):
        for _ in range(3):
            assert beats.acquire(timeout=PATIENCE_S)
    assert "unexpected" in caplog.text
