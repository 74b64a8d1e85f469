"""Which database the tests run on: SQLite, or PostgreSQL by ``pytest --database postgresql``."""

from __future__ import annotations

import hashlib
import os
import secrets
import sqlite3
import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

from sqlalchemy import URL, make_url

from testsupport.postgres import cluster
from tril.settings import Settings
from tril.store import behaviours
from tril.store.database import Database
from tril.store.schema import check_schema, upgrade

CHOICE = "TESTS_DATABASE"
"""Tells the processes that tests start which database was chosen."""


def on_postgresql() -> bool:
    """Whether tests were asked to run on PostgreSQL."""
    return os.environ.get(CHOICE) == "postgresql"


def settings_on(data: Path, **more: Any) -> Settings:
    """Return the settings of a data folder, with the database that belongs to it.

    Args:
        data: The data folder.
        **more: Other settings by name.
    """
    return Settings(data=data, **{**_database_of(data), **more})


def _database_of(data: Path) -> dict[str, str]:
    if not on_postgresql():
        return {}
    # Every process that is given the folder finds the same name.
    name = f"tril_{hashlib.blake2b(str(data.resolve()).encode(), digest_size=12).hexdigest()}"
    server = cluster()
    if not server.has(name):
        server.create(name)
    return {"database_url": server.url(name)}


def new_url(folder: Path) -> str:
    """Return the URL of an empty database, which SQLite makes in a folder when it is opened."""
    name = f"tril_{secrets.token_hex(8)}"
    if not on_postgresql():
        url = URL.create("sqlite", database=str(folder / f"{name}.sqlite"))
        return url.render_as_string(hide_password=False)
    server = cluster()
    server.create(name)
    return server.url(name)


def copy_database(template: Settings, to: Path) -> None:
    """Give a data folder the database of another one, which is not open."""
    if on_postgresql():
        wanted, given = _name(settings_on(to)), _name(template)
        cluster().drop(wanted)
        cluster().create(wanted, template=given)


def corrupt_databases(data: Path) -> list[str]:
    """Return the SQLite databases of a data folder that fail an integrity check, and why."""
    wrong = []
    for path in data.glob("*.sqlite"):
        connection = sqlite3.connect(path)
        found = connection.execute("PRAGMA integrity_check").fetchone()[0]
        connection.close()
        if found != "ok":
            wrong.append(f"{path.name}: {found}")
    return wrong


def _name(settings: Settings) -> str:
    name = make_url(settings.application_url).database
    assert name is not None
    return name


def upgrade_at_once(opened: Callable[[], Database]) -> None:
    """Upgrade a database from three threads at the same time, and check what it has become.

    Args:
        opened: Opens the database anew.
    """
    barrier = threading.Barrier(3)

    def run(_: int) -> None:
        database = opened()
        barrier.wait()
        upgrade(database)
        database.close()

    with ThreadPoolExecutor(3) as threads:
        list(threads.map(run, range(3)))
    database = opened()
    check_schema(database)
    with database.reading() as session:
        assert len(behaviours.listing(session)) == 7
    database.close()
