"""A database whose file is moved, removed or replaced while it is open."""

from __future__ import annotations

import shutil

import pytest

from testsupport.databases import on_postgresql
from testsupport.workplace import Workplace
from tril.store import players
from tril.store.database import DatabaseReplaced, create_database

pytestmark = pytest.mark.skipif(on_postgresql(), reason="about SQLite's files")


@pytest.mark.parametrize("is_replaced", [False, True])
def test_nothing_is_written_to_a_file_that_is_no_longer_there(
    workplace: Workplace, is_replaced: bool
) -> None:
    file = workplace.settings.data / "tril.sqlite"
    database = create_database(workplace.settings.application_url)
    with database.writing() as session:
        players.rename(session, players.owner(session), "Ada")
    file.rename(file.with_name("away"))
    if is_replaced:
        shutil.copy(file.with_name("away"), file)
    for _ in range(2):
        with (
            pytest.raises(DatabaseReplaced, match="moved, removed or replaced"),
            database.writing() as session,
        ):
            players.rename(session, players.owner(session), "Ben")
        with pytest.raises(DatabaseReplaced), database.reading():
            pass
    # Nor is an empty one made in its place.
    assert file.exists() == is_replaced
    file.with_name("away").rename(file)
    with database.writing() as session:
        players.rename(session, players.owner(session), "Eve")
    database.close()
