"""The database's shape: made, upgraded, and refused when it is another version's."""

from __future__ import annotations

import sqlite3
import threading
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest
from alembic import command
from sqlalchemy import inspect, select, text

from testsupport.databases import upgrade_at_once
from tril.demonstrators import play_varied
from tril.errors import Unavailable
from tril.games.space_invaders import SPACE_INVADERS
from tril.recipes import FAST
from tril.store import behaviours, players, recordings
from tril.store.database import Database, create_database, use_wal
from tril.store.models import Base, RecordingRow, Source
from tril.store.schema import alembic_config, check_schema, upgrade
from tril.store.training import runs
from tril.teaching.new_run import create_run


def open_database(folder: Path) -> Database:
    return create_database(f"sqlite:///{folder / 'tril.sqlite'}")


@pytest.fixture
def database(tmp_path: Path) -> Iterator[Database]:
    made = open_database(tmp_path)
    yield made
    made.close()


def test_an_upgrade_makes_every_table_and_adds_what_is_built_in(database: Database) -> None:
    with pytest.raises(Unavailable, match="tril migrate"):
        check_schema(database)
    upgrade(database)
    check_schema(database)
    tables = set(inspect(database.engine).get_table_names())
    assert tables == set(Base.metadata.tables) | {"alembic_version"}
    with database.writing() as session:
        players.rename(session, players.owner(session), "Ada")
    upgrade(database)
    with database.reading() as session:
        assert players.owner(session).name == "Ada", "a second upgrade changes nothing"
        assert len(behaviours.listing(session)) == 7


def test_processes_that_upgrade_at_once_do_not_get_into_each_others_way(tmp_path: Path) -> None:
    upgrade_at_once(lambda: open_database(tmp_path))


def test_a_fresh_file_can_be_switched_to_wal_while_others_do_the_same(tmp_path: Path) -> None:
    path = tmp_path / "fresh.sqlite"
    slow = sqlite3.connect(path, isolation_level=None, check_same_thread=False)
    slow.execute("BEGIN EXCLUSIVE")
    hold = threading.Timer(0.2, slow.execute, ["COMMIT"])
    hold.start()
    connection = sqlite3.connect(path, timeout=0.0)
    use_wal(connection.cursor())
    assert connection.execute("PRAGMA journal_mode").fetchone() == ("wal",)
    hold.join()
    connection.close()
    slow.close()


def test_a_newer_database_is_refused_and_left_alone(database: Database) -> None:
    upgrade(database)
    with database.engine.begin() as connection:
        connection.execute(text("UPDATE alembic_version SET version_num = '9999'"))
    for work in (check_schema, upgrade):
        with pytest.raises(Unavailable, match="newer version"):
            work(database)


def test_an_older_database_says_how_to_bring_it_up_to_date(
    database: Database, monkeypatch: pytest.MonkeyPatch
) -> None:
    upgrade(database)
    monkeypatch.setattr(
        "tril.store.schema.ScriptDirectory.get_current_head", lambda _directory: "later"
    )
    with pytest.raises(Unavailable, match=r"older version.*tril migrate.*Nothing is lost"):
        check_schema(database)


def test_a_downgrade_to_a_version_without_parents_keeps_the_runs(database: Database) -> None:
    upgrade(database)
    with database.writing() as session:
        column_1 = behaviours.by_slug(session, "column-1").id
        parent = create_run(session, column_1, FAST, 10, 0, example=True)
        child = create_run(session, column_1, FAST, 10, 0, example=True)
        child.parent_run_id = parent.id
    with database.engine.execution_options(tril_writes=True).begin() as connection:
        config = alembic_config()
        config.attributes["connection"] = connection
        command.downgrade(config, "0005")
        columns = {column["name"] for column in inspect(connection).get_columns("runs")}
    assert "parent_run_id" not in columns
    upgrade(database)
    check_schema(database)
    with database.reading() as session:
        assert [row.parent_run_id for row in runs.listing(session)] == [None, None]


def test_an_upgrade_renames_random_play(database: Database) -> None:
    upgrade(database)
    game = play_varied(np.random.default_rng(0), SPACE_INVADERS.make_console())
    with database.writing() as session:
        column_1 = behaviours.by_slug(session, "column-1").id
        recordings.add(session, column_1, game.recording, game.replay, Source.VARIED)
        recordings.add(session, column_1, game.recording, game.replay, Source.SCRIPTED)
    with database.engine.execution_options(tril_writes=True).begin() as connection:
        config = alembic_config()
        config.attributes["connection"] = connection
        command.downgrade(config, "0006")
        sources = connection.execute(text("SELECT source FROM recordings ORDER BY id"))
        assert [row.source for row in sources] == ["random", "scripted"]
    upgrade(database)
    with database.reading() as session:
        rows = session.scalars(select(RecordingRow).order_by(RecordingRow.id))
        assert [row.source for row in rows] == [Source.VARIED, Source.SCRIPTED]


def test_a_database_that_can_not_be_opened_is_named_so(tmp_path: Path) -> None:
    (tmp_path / "tril.sqlite").mkdir()
    database = open_database(tmp_path)
    with pytest.raises(Unavailable, match="can't be reached"):
        check_schema(database)
    database.close()


def test_writers_wait_for_each_other_and_lose_nothing(tmp_path: Path) -> None:
    databases = [open_database(tmp_path) for _ in range(3)]
    upgrade(databases[0])

    def count(database: Database) -> None:
        for _ in range(20):
            with database.writing() as session:
                row = players.owner(session)
                row.name = str(int(row.name) + 1 if row.name.isdecimal() else 1)

    with ThreadPoolExecutor(3) as threads:
        list(threads.map(count, databases))
    with databases[0].reading() as session:
        assert players.owner(session).name == "60"
    for database in databases:
        database.close()


def test_a_failed_transaction_leaves_nothing(database: Database) -> None:
    upgrade(database)

    def fail() -> None:
        with database.writing() as session:
            players.rename(session, players.owner(session), "Ada")
            raise RuntimeError("no")

    with pytest.raises(RuntimeError):
        fail()
    with database.reading() as session:
        assert players.owner(session).name == players.OWNER_NAME


def test_runs_of_the_first_version_learned_from_the_ordinary_example(database: Database) -> None:
    config = alembic_config()
    with database.engine.begin() as connection:
        config.attributes["connection"] = connection
        command.upgrade(config, "0001")
        connection.execute(
            text(
                "INSERT INTO behaviours (id, slug, name, description, ordered, ready_made,"
                " created_at) VALUES (1, 'own', 'Own', '', 0, 0, '2026-01-01')"
            )
        )
        connection.execute(
            text(
                "INSERT INTO runs (id, behaviour_id, example, recipe_name, recipe, training_seed,"
                " steps, go_on_anyway, versions, status, stage, stage_done, message,"
                " finished_stages, epoch, worker, outcome, created_at) VALUES ('a', 1, 1, 'fast',"
                " '{}', 0, 1, 0, '{}', 'done', '', 1, '', '{}', 1, '', '{}', '2026-01-01')"
            )
        )
    upgrade(database)
    with database.reading() as session:
        assert runs.get(session, "a").example_kind == "scripted"
