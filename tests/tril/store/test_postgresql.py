"""What SQLite's one writer gives for nothing, PostgreSQL has to be asked for."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from datetime import timedelta

import pytest
from sqlalchemy import func, select, text
from sqlalchemy.exc import DBAPIError, OperationalError

from testsupport.databases import upgrade_at_once
from testsupport.postgres import Cluster, cluster, find_or_install
from testsupport.waiting import wait_until
from tril.recipes import FAST
from tril.store import behaviours, players, processes
from tril.store.changes import ChangeReader, note_change
from tril.store.database import Database, create_database, database_now
from tril.store.models import ChangeRow
from tril.store.schema import upgrade
from tril.store.training import leases
from tril.teaching.new_run import create_run

TEMPLATE = "tril_migrated"


@pytest.fixture(scope="module")
def server() -> Cluster:
    if find_or_install() is None:
        pytest.skip("needs PostgreSQL's initdb and postgres; none is installed or installable")
    made = cluster()
    if not made.has(TEMPLATE):
        made.create(TEMPLATE)
        database = create_database(made.url(TEMPLATE))
        upgrade(database)
        database.close()
    return made


@pytest.fixture
def url(server: Cluster, request: pytest.FixtureRequest) -> Iterator[str]:
    name = f"tril_{abs(hash(request.node.name)):x}"
    server.create(name, template=TEMPLATE)
    yield server.url(name)
    server.drop(name)


@pytest.fixture
def database(url: str) -> Iterator[Database]:
    made = create_database(url)
    yield made
    made.close()


def waits_for_lock(database: Database) -> bool:
    with database.engine.connect() as connection:
        found = connection.execute(
            text(
                "SELECT count(*) FROM pg_stat_activity WHERE datname = current_database()"
                " AND wait_event_type = 'Lock'"
            )
        )
        return int(found.scalar_one()) > 0


def test_a_change_that_was_noted_first_is_committed_first(database: Database) -> None:
    with database.reading() as session:
        reader = ChangeReader(session)

    def note(key: str) -> None:
        with database.writing() as session:
            note_change(session, "run", key)

    with ThreadPoolExecutor(1) as threads:
        with database.writing() as session:
            note_change(session, "run", "first")
            session.flush()
            second = threads.submit(note, "second")
            # The second one would get its id, and be committed, while the first is still at work.
            wait_until(lambda: second.done() or waits_for_lock(database))
            assert not second.done()
        second.result()
    with database.reading() as session:
        assert [row.key for row in reader.read(session)] == ["first", "second"]


def test_no_change_is_skipped_while_many_write(database: Database) -> None:
    n_writers, n_changes = 4, 15
    with database.reading() as session:
        reader = ChangeReader(session)
        last = session.scalar(select(func.max(ChangeRow.id))) or 0

    def write(writer: int) -> None:
        for number in range(n_changes):
            with database.writing() as session:
                note_change(session, "run", f"{writer}-{number}")
                session.flush()

    seen: list[int] = []
    keys: set[str] = set()
    with ThreadPoolExecutor(n_writers) as threads:
        writers = [threads.submit(write, number) for number in range(n_writers)]
        while len(keys) < n_writers * n_changes:
            over = all(writer.done() for writer in writers)
            with database.reading() as session:
                found = reader.read(session)
            seen += [row.id for row in found]
            keys |= {row.key for row in found}
            assert found or not over, "a change was skipped"
    # In this order, so that a reader which goes on from the highest id has missed none.
    assert seen == sorted(seen)
    assert seen == list(range(last + 1, last + 1 + n_writers * n_changes))


def test_what_is_read_and_then_written_was_not_changed_in_between(database: Database) -> None:
    def count(_: int) -> None:
        for _ in range(10):
            with database.writing() as session:
                row = players.owner(session)
                row.name = str(int(row.name) + 1 if row.name.isdecimal() else 1)

    with ThreadPoolExecutor(4) as threads:
        list(threads.map(count, range(4)))
    with database.reading() as session:
        assert players.owner(session).name == "40"


def test_a_reader_sees_one_state_and_holds_no_writer_up(database: Database) -> None:
    with database.reading() as session:
        assert players.owner(session).name == players.OWNER_NAME
        with database.writing() as other:
            players.rename(other, players.owner(other), "Ada")
        session.expire_all()
        assert players.owner(session).name == players.OWNER_NAME
    with database.reading() as session:
        assert players.owner(session).name == "Ada"


def test_a_reader_can_not_write(database: Database) -> None:
    with database.reading() as session, pytest.raises(DBAPIError, match="read-only"):
        session.execute(text("DELETE FROM changes"))


def test_a_writer_waits_for_another_one_but_not_for_ever(url: str) -> None:
    database = create_database(url, write_patience_s=0.1)
    with database.writing() as session:
        players.rename(session, players.owner(session), "Ada")
        with pytest.raises(OperationalError, match="lock timeout"), database.writing() as second:
            players.rename(second, players.owner(second), "Ben")
    with database.reading() as session:
        assert players.owner(session).name == "Ada"
    database.close()


def test_a_writer_that_is_silent_for_long_holds_the_others_up_no_more(
    url: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("tril.store.database.SILENT_WRITER_MS", 200)
    database, other = create_database(url), create_database(url)

    def be_silent() -> None:
        with database.writing() as session:
            players.rename(session, players.owner(session), "Ada")
            session.flush()
            with other.writing() as second:
                players.rename(second, players.owner(second), "Ben")

    with pytest.raises(DBAPIError, match="idle-in-transaction"):
        be_silent()
    with other.reading() as session:
        assert players.owner(session).name == "Ben"
    database.close()
    other.close()


def test_a_lease_with_an_older_epoch_writes_nothing_more(database: Database) -> None:
    with database.writing() as session:
        behaviour_id = behaviours.by_slug(session, "column-1").id
        run_id = create_run(session, behaviour_id, FAST, 10, 0, example=True).id
        processes.beat(session, "worker-0", "worker", {})
    n_workers = 4
    barrier = threading.Barrier(n_workers)

    def acquire(number: int) -> leases.Lease | None:
        barrier.wait()
        with database.writing() as session:
            processes.beat(session, f"worker-{number}", "worker", {})
            return leases.acquire(session, run_id, f"worker-{number}")

    with ThreadPoolExecutor(n_workers) as threads:
        taken = [lease for lease in threads.map(acquire, range(n_workers)) if lease is not None]
    assert len(taken) == 1, "one of the workers that ask at once has the run"
    (old,) = taken
    with database.writing() as session:
        assert leases.revoke(session, run_id, old.epoch)
        new = leases.acquire(session, run_id, "worker-9")
    assert new is not None
    assert new.epoch > old.epoch
    with pytest.raises(leases.LeaseLost), database.writing() as session:
        leases.report(session, old, "reward", 0.5, None)
    with database.writing() as session:
        assert not leases.beat(session, old)
        leases.report(session, new, "reward", 0.5, None)


def test_the_clock_goes_on_within_a_transaction(database: Database) -> None:
    with database.writing() as session:
        first = database_now(session)
        wait_until(lambda: database_now(session) > first)
        assert database_now(session) - first < timedelta(minutes=1)


def test_services_that_start_together_upgrade_one_after_the_other(server: Cluster) -> None:
    server.drop("tril_fresh")
    server.create("tril_fresh")
    upgrade_at_once(lambda: create_database(server.url("tril_fresh")))
    server.drop("tril_fresh")
