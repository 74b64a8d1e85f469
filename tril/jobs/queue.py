"""The job queue's database, and how its jobs are named."""

from __future__ import annotations

import logging
import sqlite3
from pathlib import Path

from dbos import DBOS, DBOSClient, DBOSConfig, DBOSPortableJSONSerializer, Serializer
from dbos._utils import GlobalParams
from sqlalchemy import make_url

from tril.settings import Settings
from tril.store.database import use_wal, with_keepalives
from tril.store.models import RunDevice

APPLICATION = "tril"
QUEUES = {RunDevice.ANY: "runs", RunDevice.GPU: "runs-gpu"}
"""Every worker takes runs that need no certain device; one with a GPU those that need it, too."""
WORKFLOW = "train"
VERSION = "1"
"""Jobs of another version are left alone. Raised when a job's argument, the run's id, changes."""

POLL_S = 0.5

# DBOS__CLOUD is for an application of DBOS's cloud, whose name and database the queue would take.
# It is read when DBOS is loaded, which may be before anything of this package is.
GlobalParams.dbos_cloud = False


def prepare_queue(settings: Settings) -> None:
    """Create or upgrade the queue's database and register its queues; harmless when repeated.

    Has to be done before anything is enqueued: the queue's client never migrates.
    """
    _quiet_dbos()
    url = make_url(settings.queue_url)
    if url.get_backend_name() == "sqlite" and url.database:
        path = Path(url.database)
        path.parent.mkdir(parents=True, exist_ok=True)
        _use_wal(path)
    DBOS.migrate(_url(settings))
    client = open_client(settings)
    try:
        for queue in QUEUES.values():
            client.register_queue(queue, worker_concurrency=1, polling_interval_sec=POLL_S)
    finally:
        client.destroy()


def open_client(settings: Settings) -> DBOSClient:
    """Open the queue for enqueuing, cancelling and listing jobs."""
    _quiet_dbos()
    return DBOSClient(
        system_database_url=_url(settings),
        application_name=APPLICATION,
        serializer=_serializer(),
        lazy=True,
    )


def executor_config(settings: Settings, name: str) -> DBOSConfig:
    """Return the configuration by which a process takes jobs from the queue.

    Args:
        settings: Say where the queue is.
        name: Name of the process; a later one of that name takes back the jobs that it left.
    """
    return {
        "name": APPLICATION,
        "system_database_url": _url(settings),
        "executor_id": name,
        "application_version": VERSION,
        "serializer": _serializer(),
        "log_level": "WARNING",
    }


def _url(settings: Settings) -> str:
    return with_keepalives(settings.queue_url).render_as_string(hide_password=False)


def _serializer() -> Serializer:
    # A job's argument, the run's id, is written as JSON and not as a pickle.
    return DBOSPortableJSONSerializer()


def _quiet_dbos() -> None:
    logging.getLogger("dbos").setLevel(logging.WARNING)


def _use_wal(path: Path) -> None:
    connection = sqlite3.connect(path, timeout=30.0)
    try:
        use_wal(connection.cursor())
    finally:
        connection.close()
