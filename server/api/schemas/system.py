"""Whether Tril is well."""

from __future__ import annotations

from typing import Any, Literal

from server.api.schemas.base import Schema


class Health(Schema):
    """The server answers."""

    status: Literal["ok"]


class ProcessStatus(Schema):
    """``alive`` is false when nothing was heard for 15 s."""

    name: str
    kind: Literal["server", "worker", "inference"]
    alive: bool
    details: dict[str, Any]


class Storage(Schema):
    """What the data folder holds; the cache never takes more than its limit."""

    databases_bytes: int
    artifacts_bytes: int
    cache_bytes: int
    cache_limit_bytes: int
    other_bytes: int


class System(Schema):
    """Whether Tril is well. ``data_bytes`` is what the parts of ``storage`` take together."""

    version: str
    processes: list[ProcessStatus]
    disk_free_bytes: int
    data_bytes: int
    storage: Storage
