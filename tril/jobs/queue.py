"""The job queue's database and what names a job in it."""

from __future__ import annotations

import logging
import sqlite3
from pathlib import Path

from dbos import DBOS, DBOSClient, DBOSPortableJSONSerializer, Serializer
from sqlalchemy import make_url

from tril.settings import Settings
from tril.store.database import use_wal

APPLICATION = "tril"
QUEUE = "runs"
WORKFLOW = "train"
VERSION = "1"
"""Jobs of another version are left alone. It is raised only when a job's arguments change, which
is next to never: they are the run's id."""

POLL_S = 0.5


def prepare_queue(settings: Settings) -> None:
    """Create or upgrade the queue's database and describe its queue; harmless when repeated.

    Has to be done once before anything is enqueued: the queue's client never migrates.
    """
    quiet_dbos()
    url = make_url(settings.queue_url)
    if url.get_backend_name() == "sqlite" and url.database:
        path = Path(url.database)
        path.parent.mkdir(parents=True, exist_ok=True)
        _use_wal(path)
    DBOS.migrate(settings.queue_url)
    client = open_client(settings)
    try:
        client.register_queue(QUEUE, worker_concurrency=1, polling_interval_sec=POLL_S)
    finally:
        client.destroy()


def open_client(settings: Settings) -> DBOSClient:
    """Open the queue for enqueuing, cancelling and looking."""
    quiet_dbos()
    return DBOSClient(
        system_database_url=settings.queue_url,
        application_name=APPLICATION,
        serializer=serializer(),
        lazy=True,
    )


def serializer() -> Serializer:
    """Make what writes a job's argument (the run's id) into the queue: as JSON, not as a pickle."""
    return DBOSPortableJSONSerializer()


def quiet_dbos() -> None:
    """Let DBOS speak up only when something is wrong."""
    logging.getLogger("dbos").setLevel(logging.WARNING)


def _use_wal(path: Path) -> None:
    connection = sqlite3.connect(path, timeout=30.0)
    try:
        use_wal(connection.cursor())
    finally:
        connection.close()
