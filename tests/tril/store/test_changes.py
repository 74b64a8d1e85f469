"""The table of changes, read while others write to it."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from testsupport.workplace import Workplace
from tril.store.changes import MAX_GAPS, ChangeReader, note_change
from tril.store.database import Database
from tril.store.models import ChangeRow


@pytest.fixture
def database(workplace: Workplace) -> Database:
    return workplace.database


def reader_of(database: Database, late_commit_s: float = 60) -> Callable[[], list[int]]:
    """Return what reads the ids of new changes."""
    with database.reading() as session:
        reader = ChangeReader(session, late_commit_s)

    def read() -> list[int]:
        with database.reading() as session:
            return [row.id for row in reader.read(session)]

    return read


def write(database: Database, *ids: int) -> None:
    with database.writing() as session:
        session.add_all(ChangeRow(id=key, topic="run", key=str(key)) for key in ids)


def last_id(database: Database) -> int:
    with database.writing() as session:
        row = ChangeRow(topic="run", key="newest")
        session.add(row)
        session.flush()
        return row.id


def test_changes_are_read_once_in_their_order(database: Database) -> None:
    read = reader_of(database)
    assert read() == []
    with database.writing() as session:
        for key in "abc":
            note_change(session, "run", key)
    ids = read()
    assert ids == sorted(ids)
    assert len(ids) == 3
    assert read() == []


def test_changes_that_are_committed_after_later_ones_are_read(database: Database) -> None:
    last = last_id(database)
    read = reader_of(database)
    write(database, last + 4)
    assert read() == [last + 4]
    write(database, last + 2)
    assert read() == [last + 2]
    write(database, last + 1, last + 3, last + 5)
    assert read() == [last + 1, last + 3, last + 5]
    assert read() == []


def test_a_change_that_was_noted_before_the_reader_began_is_read(database: Database) -> None:
    last = last_id(database)
    write(database, last + 2)
    read = reader_of(database)
    write(database, last + 1)
    assert read() == [last + 1]


def test_changes_that_do_not_appear_are_given_up(database: Database) -> None:
    last = last_id(database)
    read = reader_of(database, late_commit_s=0)
    write(database, last + 2)
    assert read() == [last + 2]
    assert read() == []
    write(database, last + 1)
    assert read() == []


def test_a_jump_of_ids_is_no_burden(database: Database) -> None:
    last = last_id(database)
    read = reader_of(database)
    write(database, last + 10**9)
    assert read() == [last + 10**9]
    write(database, last + 10**9 - MAX_GAPS, last + 10**9 + 1)
    assert read() == [last + 10**9 - MAX_GAPS, last + 10**9 + 1]
