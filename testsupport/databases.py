"""Which database the tests run on: SQLite, or PostgreSQL by ``pytest --database postgresql``."""

from __future__ import annotations

import hashlib
import os
import secrets
from pathlib import Path
from typing import Any

from sqlalchemy import make_url

from testsupport.postgres import cluster
from tril.settings import Settings

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
        return f"sqlite:///{folder / name}.sqlite"
    server = cluster()
    server.create(name)
    return server.url(name)


def copy_database(template: Settings, to: Path) -> None:
    """Give a data folder the database of another one, which is not open."""
    if on_postgresql():
        wanted, given = _name(settings_on(to)), _name(template)
        cluster().drop(wanted)
        cluster().create(wanted, template=given)


def _name(settings: Settings) -> str:
    name = make_url(settings.application_url).database
    assert name is not None
    return name
