"""Engine and sessions on SQLite or PostgreSQL, which behave alike: many read, one writes.

What is read and then written in one transaction was not changed by another in between, and changes
are committed in the order of their ids. Both hold because writers wait for each other: in SQLite by
BEGIN IMMEDIATE, in PostgreSQL by an advisory lock that is the first thing a transaction takes.
"""

from __future__ import annotations

import json
import sqlite3
import time
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from datetime import datetime
from pathlib import Path
from typing import Any, Protocol

from pydantic_core import from_json
from sqlalchemy import URL, Connection, Engine, create_engine, event, make_url, text
from sqlalchemy.exc import DBAPIError, OperationalError
from sqlalchemy.orm import Session, sessionmaker

from tril.store.models import UTCDateTime

_SQLITE_NOW = text("SELECT strftime('%Y-%m-%d %H:%M:%f000', 'now') AS moment").columns(
    moment=UTCDateTime()
)
# Not now(), which is when the transaction began, perhaps before it waited for a lock.
_POSTGRESQL_NOW = text("SELECT clock_timestamp() AS moment").columns(moment=UTCDateTime())

WRITE_PATIENCE_S = 15.0
"""Longest that a writer waits for others, unless it is patient."""
SILENT_WRITER_MS = 60_000
"""PostgreSQL ends a writer's transaction that does nothing for so long: its machine may be gone."""
WAL_RETRY_S = 0.01

KEEPALIVES = {
    "connect_timeout": "10",
    "keepalives_idle": "10",
    "keepalives_interval": "5",
    "keepalives_count": "3",
    "tcp_user_timeout": "30000",
}
"""Parameters of libpq: a connection over TCP breaks within 30 s of its last sign of life."""

_LOCK_TIMEOUT = "55P03"
_AWAY = ("08", "57P0")
"""Beginnings of PostgreSQL's codes for connections that break, and a server that ends or starts."""

WRITE_LOCK = 8_411_105_108
"""Key of the advisory lock that a PostgreSQL transaction which writes holds until its end."""


class WriteGuard(Protocol):
    """Judges the transactions of a request, see tril.store.submissions."""

    def check(self, session: Session) -> None:
        """Raise unless the transaction may write."""

    def note(self, session: Session) -> None:
        """Add what is committed with the transaction's changes."""


WRITE_GUARD: ContextVar[WriteGuard | None] = ContextVar("write_guard", default=None)
"""What judges the transactions of this thread or task."""


def parse_json(stored: str) -> Any:
    """Parse a column's JSON; pydantic's parser is the faster one, but takes no lone surrogate."""
    try:
        return from_json(stored)
    except ValueError:
        return json.loads(stored)


def create_database(url: str, write_patience_s: float = WRITE_PATIENCE_S) -> Database:
    """Open the database at an SQLAlchemy URL; creates nothing but SQLite's folder.

    Args:
        url: The URL.
        write_patience_s: Longest that a transaction which writes waits for others that do.
    """
    parsed = with_keepalives(url)
    if parsed.get_backend_name() == "sqlite" and parsed.database:
        Path(parsed.database).parent.mkdir(parents=True, exist_ok=True)
    engine = create_engine(
        parsed,
        pool_pre_ping=parsed.get_backend_name() != "sqlite",
        # Most of the time of a large library's query is spent parsing JSON; json.loads takes more
        # than twice as long.
        json_deserializer=parse_json,
    )
    if parsed.get_backend_name() == "sqlite":
        _set_up_sqlite(engine, write_patience_s)
    elif parsed.get_backend_name() == "postgresql":
        _set_up_postgresql(engine, write_patience_s)
    return Database(engine)


def with_keepalives(url: str) -> URL:
    """Return a URL by which a connection to PostgreSQL that the network has lost breaks in time.

    The server may have ended it without being heard. Whoever waits for an answer then waits for
    two hours, which is when Linux first asks whether the other end is still there.
    """
    parsed = make_url(url)
    if parsed.get_backend_name() != "postgresql":
        return parsed
    return parsed.set(query={**KEEPALIVES, **parsed.query})


class DatabaseReplaced(OperationalError):
    """SQLite's file was moved, removed or replaced: what is written would be lost with it."""

    def __init__(self, file: Path) -> None:
        reason = (
            f"{file} was moved, removed or replaced while Tril was running. Put the data folder"
            " back, or stop Tril and start it again"
        )
        super().__init__(None, None, sqlite3.OperationalError(reason))


class Database:
    """Transactions on one database.

    ``reading`` opens a session that sees one consistent state and never writes; ``writing`` opens
    one that holds the write lock from its first statement (in SQLite, upgrading a read transaction
    would fail at once) and commits at the end of the block.
    """

    def __init__(self, engine: Engine) -> None:
        self.engine = engine
        name = engine.url.database if engine.dialect.name == "sqlite" else None
        self._file = Path(name) if name and name != ":memory:" else None
        self._file_id: tuple[int, int] | None = None
        self._reading = sessionmaker(
            engine.execution_options(**_READING.get(engine.dialect.name, {})),
            expire_on_commit=False,
            autoflush=False,
        )
        self._writing = sessionmaker(
            engine.execution_options(tril_writes=True), expire_on_commit=False
        )

    @contextmanager
    def reading(self) -> Iterator[Session]:
        """Open a session for reading; its rows stay readable after the block."""
        self._check_file()
        with self._reading() as session:
            try:
                yield session
            finally:
                # A rollback would forget what was read of the rows that are still in the session.
                session.expunge_all()
                session.rollback()

    @contextmanager
    def writing(self) -> Iterator[Session]:
        """Open a session for one transaction; commits at the end, rolls back on an error.

        ``WRITE_GUARD`` judges it first, and adds to it last.
        """
        guard = WRITE_GUARD.get()
        self._check_file()
        with self._writing.begin() as session:
            if guard is not None:
                guard.check(session)
            yield session
            if guard is not None:
                guard.note(session)

    def _check_file(self) -> None:
        """Raise DatabaseReplaced unless SQLite's file is the one that was opened first."""
        if self._file is None:
            return
        try:
            status = self._file.stat()
        except FileNotFoundError:
            if self._file_id is None:
                return
            raise DatabaseReplaced(self._file) from None
        file_id = (status.st_dev, status.st_ino)
        self._file_id = self._file_id or file_id
        if self._file_id != file_id:
            raise DatabaseReplaced(self._file)

    @contextmanager
    def upgrading(self) -> Iterator[Connection]:
        """Open a connection that alters tables; it waits for writers, and they for it.

        PostgreSQL bounds neither how long it waits nor how long it is silent, since a copy of the
        database may be made meanwhile.
        """
        options = {"tril_writes": True, "tril_upgrades": True}
        with self.engine.execution_options(**options).begin() as connection:
            yield connection

    def close(self) -> None:
        """Close every connection."""
        self.engine.dispose()


def database_now(session: Session) -> datetime:
    """Return the present moment, in UTC, by the database's clock.

    It is the one clock that processes of several machines share: whatever one writes and another
    judges is written and compared by it, such as heartbeats, leases, and when a game finished.
    """
    is_sqlite = session.get_bind().dialect.name == "sqlite"
    query = _SQLITE_NOW if is_sqlite else _POSTGRESQL_NOW
    # Not by the session, which would first write what is still being put together in it.
    moment: datetime = session.connection().execute(query).scalar_one()
    return moment


def is_unreachable(error: DBAPIError) -> bool:
    """Whether the database could not be reached, or the connection to it broke."""
    if isinstance(error, DatabaseReplaced):
        return True
    return error.connection_invalidated or _code(error).startswith(_AWAY)


def is_busy(error: DBAPIError) -> bool:
    """Whether another writer took longer than a writer waits."""
    text = str(error.orig).lower()
    return "locked" in text or "busy" in text or _code(error) == _LOCK_TIMEOUT


def _code(error: DBAPIError) -> str:
    """Return PostgreSQL's code of an error; empty for SQLite."""
    code: str | None = getattr(error.orig, "sqlstate", "")
    if code is None and isinstance(error, OperationalError):
        return _AWAY[0]  # There was no connection to tell one by.
    return code or ""


def use_wal(cursor: sqlite3.Cursor) -> None:
    """Switch an SQLite file to write-ahead logging, waiting for others that do the same.

    SQLite's busy timeout does not cover this: of two processes that switch a fresh file at the
    same time, one fails at once because the file is locked.

    Raises:
        sqlite3.OperationalError: The file stayed locked, or can't be written.
    """
    give_up_at = time.monotonic() + WRITE_PATIENCE_S
    while True:
        try:
            cursor.execute("PRAGMA journal_mode=WAL")
        except sqlite3.OperationalError as error:
            locked = error.sqlite_errorcode & 0xFF in {sqlite3.SQLITE_BUSY, sqlite3.SQLITE_LOCKED}
            if not locked or time.monotonic() >= give_up_at:
                raise
            time.sleep(WAL_RETRY_S)
        else:
            return


_READING: dict[str, dict[str, Any]] = {
    # Otherwise every statement sees what was committed before it.
    "postgresql": {"isolation_level": "REPEATABLE READ", "postgresql_readonly": True}
}


def _set_up_sqlite(engine: Engine, write_patience_s: float) -> None:
    """Turn on durable WAL, foreign keys and waiting writers; SQLAlchemy begins transactions."""

    @event.listens_for(engine, "connect")
    def _on_connect(connection: Any, _record: Any) -> None:
        connection.isolation_level = None
        cursor = connection.cursor()
        cursor.execute(f"PRAGMA busy_timeout={round(write_patience_s * 1000)}")
        use_wal(cursor)
        cursor.execute("PRAGMA synchronous=FULL")
        cursor.execute("PRAGMA foreign_keys=ON")
        cursor.close()

    @event.listens_for(engine, "begin")
    def _on_begin(connection: Any) -> None:
        writes = connection.get_execution_options().get("tril_writes", False)
        connection.exec_driver_sql("BEGIN IMMEDIATE" if writes else "BEGIN")


def _set_up_postgresql(engine: Engine, write_patience_s: float) -> None:
    """Let writers wait for each other, as SQLite's do, and none wait for ever."""

    @event.listens_for(engine, "connect")
    def _on_connect(connection: Any, _record: Any) -> None:
        # Not by the connection's options, which poolers between here and the server may refuse.
        connection.execute(f"SET lock_timeout = {round(write_patience_s * 1000)}")
        connection.execute(f"SET idle_in_transaction_session_timeout = {SILENT_WRITER_MS}")
        connection.commit()

    @event.listens_for(engine, "begin")
    def _on_begin(connection: Any) -> None:
        options = connection.get_execution_options()
        if options.get("tril_upgrades", False):
            connection.exec_driver_sql("SET LOCAL lock_timeout = 0")
            connection.exec_driver_sql("SET LOCAL idle_in_transaction_session_timeout = 0")
        if options.get("tril_writes", False):
            connection.exec_driver_sql(f"SELECT pg_advisory_xact_lock({WRITE_LOCK})")
