"""Copies of whole databases, made while others use them: SQLite's files, PostgreSQL's dumps."""

from __future__ import annotations

import os
import re
import shutil
import sqlite3
import subprocess
from contextlib import closing
from datetime import UTC, datetime
from pathlib import Path

from sqlalchemy import URL, Engine, make_url, text

from tril.errors import Unavailable

KEPT_COPIES = 2
"""Copies made before upgrades that are kept."""

_PREFIX = "before-upgrade-from-"


class CopyFailed(Unavailable):
    """A database could not be copied."""


def copy_sqlite(source: Path, to: Path) -> None:
    """Copy a database as it is at one moment, without blocking writers; the copy is on the disk."""
    # All pages in one step: one consistent state, however much is written meanwhile.
    with closing(sqlite3.connect(source)) as live, closing(sqlite3.connect(to)) as copy:
        live.backup(copy, pages=-1)
        # A single file without a log beside it.
        copy.execute("PRAGMA journal_mode=DELETE")
    _sync(to)


def dump_postgresql(engine: Engine, to: Path, snapshot: str | None = None) -> None:
    """Write a database into a file that pg_restore reads.

    Args:
        engine: The database.
        to: The file, in pg_dump's custom format.
        snapshot: The state to write, as exported by a transaction; else that of this moment.

    Raises:
        CopyFailed: pg_dump is missing, older than the server, or failed.
    """
    check_pg_dump(engine)
    snapshot_options = [] if snapshot is None else [f"--snapshot={snapshot}"]
    _run(engine.url, "pg_dump", "--format=custom", f"--file={to}", *snapshot_options)
    _sync(to)


def check_pg_dump(engine: Engine) -> None:
    """Refuse a database that no pg_dump here can write; raises CopyFailed."""
    with engine.connect() as connection:
        number = connection.execute(text("SHOW server_version_num")).scalar_one()
    server = int(number) // 10_000
    needed = (
        f"Install PostgreSQL's client programs of version {server} or newer (Debian: apt install"
        " postgresql-client) and put pg_dump on the PATH."
    )
    program = shutil.which("pg_dump")
    if program is None:
        raise CopyFailed(f"The database can't be copied: there is no pg_dump. {needed}")
    result = subprocess.run(
        [program, "--version"], capture_output=True, encoding="utf-8", errors="replace", check=False
    )
    match = re.search(r"\) (\d+)", result.stdout)
    if match is None or int(match[1]) < server:
        raise CopyFailed(
            f"The database can't be copied: {result.stdout.strip() or program} is older than its"
            f" server (PostgreSQL {server}). {needed}"
        )


def check_dump(place: Path) -> None:
    """Let pg_restore, if there is one, read what a dump contains; raises CopyFailed."""
    if shutil.which("pg_restore") is not None:
        _run(None, "pg_restore", "--list", str(place))


def copy_before_upgrade(engine: Engine, revision: str, folder: Path) -> Path:
    """Copy a database that is about to be upgraded, and forget all but the newest two copies.

    Args:
        engine: The database, which nobody writes to meanwhile.
        revision: Present revision of the database.
        folder: Where the copies are kept.

    Returns:
        The copy.

    Raises:
        CopyFailed: It can't be copied; nothing was changed.
    """
    is_sqlite = engine.dialect.name == "sqlite"
    moment = datetime.now(UTC)
    ending = "sqlite" if is_sqlite else "dump"
    place = folder / f"{moment:%Y%m%d-%H%M%S-%f}-{_PREFIX}{revision}.{ending}"
    unfinished = place.with_name(f".{place.name}")
    try:
        folder.mkdir(parents=True, exist_ok=True, mode=0o700)
        if is_sqlite:
            assert engine.url.database is not None
            copy_sqlite(Path(engine.url.database), unfinished)
        else:
            dump_postgresql(engine, unfinished)
        unfinished.rename(place)
    except (OSError, sqlite3.Error) as error:
        raise CopyFailed(f"The database can't be copied to {folder}: {error}.") from error
    finally:
        if unfinished.is_file():
            unfinished.unlink()
    for copy in sorted(folder.glob(f"[0-9]*-{_PREFIX}*"))[:-KEPT_COPIES]:
        copy.unlink()
    return place


def _run(url: URL | None, program: str, *arguments: str) -> None:
    environ = dict(os.environ)
    if url is not None:
        from psycopg.conninfo import make_conninfo

        # Not the password, which other users of the machine would see among the arguments.
        if url.password:
            environ["PGPASSWORD"] = str(url.password)
        # Not a URL: libpq reads neither spaces nor plus signs as SQLAlchemy writes them.
        place = {**url.get_dialect()().create_connect_args(url)[1], "password": None}
        arguments = (*arguments, "--no-password", f"--dbname={make_conninfo(**place)}")
    result = subprocess.run(
        [program, *arguments],
        env=environ,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        encoding="utf-8",
        errors="replace",
        check=False,
    )
    if result.returncode:
        raise CopyFailed(f"{program} failed: {result.stderr.strip()}")


def is_postgresql(url: str) -> bool:
    """Whether a URL names a PostgreSQL database."""
    return make_url(url).get_backend_name() == "postgresql"


def _sync(place: Path) -> None:
    descriptor = os.open(place, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
