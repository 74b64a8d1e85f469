"""A database of an earlier version is copied before it is upgraded."""

from __future__ import annotations

import shutil
import sqlite3
import subprocess
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import pytest
from alembic import command
from sqlalchemy import make_url, text

from testsupport.databases import new_url, on_postgresql
from testsupport.postgres import Cluster, cluster, find_or_install
from tril.store import copies, players
from tril.store.copies import CopyFailed
from tril.store.database import Database, create_database
from tril.store.schema import alembic_config, check_schema, upgrade


@pytest.fixture(params=["sqlite", "postgresql"])
def database(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[Database]:
    """A database with something in it, of this version."""
    if request.param == "sqlite" and on_postgresql():
        pytest.skip("runs with the tests on SQLite")
    if request.param == "sqlite":
        made = create_database(new_url(tmp_path))
        yield from prepared(made)
    else:
        server = postgresql()
        server.drop("tril_upgraded")
        server.create("tril_upgraded")
        yield from prepared(create_database(server.url("tril_upgraded")))
        server.drop("tril_upgraded")


def postgresql() -> Cluster:
    if find_or_install() is None:
        pytest.skip("needs PostgreSQL's initdb and postgres; none is installed or installable")
    return cluster()


def prepared(database: Database) -> Iterator[Database]:
    upgrade(database)
    with database.writing() as session:
        players.rename(session, players.owner(session), "Ada")
    yield database
    database.close()


def downgrade(database: Database, revision: str = "0007") -> None:
    with database.upgrading() as connection:
        config = alembic_config()
        config.attributes["connection"] = connection
        command.downgrade(config, revision)


def names_in(copy: Path, database: Database) -> list[str]:
    if copy.suffix == ".sqlite":
        with closing(sqlite3.connect(copy)) as opened:
            return [name for (name,) in opened.execute("SELECT name FROM players")]
    server = cluster()
    server.drop("tril_from_copy")
    server.create("tril_from_copy")
    place = server.url("tril_from_copy").replace("postgresql+psycopg", "postgresql")
    subprocess.run(["pg_restore", "--exit-on-error", f"--dbname={place}", copy], check=True)
    restored = create_database(server.url("tril_from_copy"))
    with restored.reading() as session:
        found = list(session.execute(text("SELECT name FROM players")).scalars())
    restored.close()
    return found


def test_a_copy_is_made_of_an_earlier_version_and_the_data_stay(
    database: Database, tmp_path: Path
) -> None:
    copies = tmp_path / "copies"
    downgrade(database)
    upgrade(database, copies)
    check_schema(database)
    with database.reading() as session:
        assert players.owner(session).name == "Ada"
    (copy,) = copies.iterdir()
    assert "before-upgrade-from-0007" in copy.name
    assert names_in(copy, database) == ["Ada"]


def test_no_copy_is_made_of_this_version_or_an_empty_database(
    database: Database, tmp_path: Path
) -> None:
    upgrade(database, tmp_path / "copies")
    empty = create_database(f"sqlite:///{tmp_path / 'empty.sqlite'}")
    upgrade(empty, tmp_path / "copies")
    empty.close()
    assert not (tmp_path / "copies").exists()


def test_the_newest_two_copies_are_kept(database: Database, tmp_path: Path) -> None:
    copies = tmp_path / "copies"
    found = []
    for revision in ("0007", "0006", "0005"):
        downgrade(database, revision)
        upgrade(database, copies)
        found.append(max(path.name for path in copies.iterdir()))
    assert sorted(path.name for path in copies.iterdir()) == found[1:]


def test_what_can_not_be_copied_is_not_upgraded(database: Database, tmp_path: Path) -> None:
    (tmp_path / "copies").write_text("no folder")
    downgrade(database)
    with pytest.raises(CopyFailed, match="can't be copied to"):
        upgrade(database, tmp_path / "copies")
    with database.reading() as session:
        assert session.execute(text("SELECT version_num FROM alembic_version")).scalar() == "0007"


@pytest.mark.parametrize(
    ("script", "said"),
    [(None, "there is no pg_dump"), ("echo 'pg_dump (PostgreSQL) 9.6'", "older than its server")],
)
def test_without_a_fitting_pg_dump_postgresql_is_not_upgraded(
    script: str | None, said: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    server = postgresql()
    server.drop("tril_no_dump")
    server.create("tril_no_dump")
    database = create_database(server.url("tril_no_dump"))
    upgrade(database)
    downgrade(database)
    programs = tmp_path / "bin"
    programs.mkdir()
    if script is not None:
        (programs / "pg_dump").write_text(f"#!{shutil.which('sh')}\n{script}\n")
        (programs / "pg_dump").chmod(0o755)
    monkeypatch.setenv("PATH", str(programs))
    with pytest.raises(CopyFailed, match=said):
        upgrade(database, tmp_path / "copies")
    with database.reading() as session:
        assert session.execute(text("SELECT version_num FROM alembic_version")).scalar() == "0007"
    assert list((tmp_path / "copies").iterdir()) == []
    upgrade(database)
    check_schema(database)
    database.close()
    server.drop("tril_no_dump")


def test_the_password_of_an_address_reaches_pg_dump_and_not_its_arguments(tmp_path: Path) -> None:
    program, said = tmp_path / "program", tmp_path / "said"
    program.write_text(f'#!/bin/sh\nprintf "%s\\n" "$PGPASSWORD" "$@" > {said}\n')
    program.chmod(0o755)
    url = make_url(
        "postgresql+psycopg://tril:se%20cret@db.example:5433/my%20lab?options=-c%20x%3Dy"
    )
    copies._run(url, str(program), "--format=custom")
    assert said.read_text().splitlines() == [
        "se cret",
        "--format=custom",
        "--no-password",
        "--dbname=host=db.example dbname='my lab' user=tril port=5433 options='-c x=y'",
    ]
