"""The processes and the disk usage."""

from __future__ import annotations

from typing import Any, Literal

from pydantic import Field

from server.api.schemas.base import Schema
from tril.text import Line


class Health(Schema):
    """The server runs; ``failing`` names the background tasks whose last run failed, if any."""

    status: Literal["ok", "degraded"]
    failing: list[str] | None = None


class ProcessStatus(Schema):
    """``busy`` is true after 15 s without a heartbeat if the process is known to live.

    ``alive`` is false if it is not.

    ``host``, ``cores`` and ``gpu`` say where a worker learns; ``gpu`` is null if not on one.
    """

    name: str
    kind: Literal["server", "worker", "inference"]
    alive: bool
    busy: bool
    details: dict[str, Any]
    host: str | None
    cores: int | None
    gpu: str | None


class WorkerJoining(Schema):
    """A worker of another machine: its version of Tril and of the database's schema."""

    version: Line = Field(max_length=40)
    revision: Line = Field(max_length=40)


class SharedPlaces(Schema):
    """Where a worker finds the data, credentials included.

    The file ``probe_path`` in the artifact store contains ``probe``: so a worker knows that what it
    finds at ``artifacts_url`` is the same store.
    """

    database_url: str
    jobs_database_url: str
    artifacts_url: str
    probe_path: str
    probe: str


class Storage(Schema):
    """Disk usage of the data folder by purpose; the cache is kept below its limit."""

    databases_bytes: int
    artifacts_bytes: int
    cache_bytes: int
    cache_limit_bytes: int
    other_bytes: int


class System(Schema):
    """State of the installation. ``data_bytes`` is the sum of the parts of ``storage``.

    ``has_example`` tells whether a finished training ships with it.
    """

    version: str
    processes: list[ProcessStatus]
    disk_free_bytes: int
    data_bytes: int
    storage: Storage
    has_example: bool
