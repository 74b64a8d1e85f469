"""The processes and the disk usage."""

from __future__ import annotations

import shutil

from fastapi import APIRouter, Request

from server.api.schemas.system import (
    ProcessStatus,
    SharedPlaces,
    Storage,
    System,
    WorkerJoining,
)
from server.dependencies import ReadSession, Who, services_of
from server.shared_places import probe_of, refuse_unshared
from server.web.problems import CONFLICT
from tril import __version__
from tril.errors import Conflict
from tril.exchange.example import has_example
from tril.store import audit, processes
from tril.store.schema import schema_revision

router = APIRouter(tags=["system"])
joining_router = APIRouter(tags=["system"])

_DEVICE = ("host", "cores", "gpu")


@router.get("/system")
def get_system(request: Request, session: ReadSession) -> System:
    """Return the state of the processes and the disk usage."""
    services = services_of(request)
    settings, use = services.settings, services.storage.use()
    return System(
        version=__version__,
        processes=[
            ProcessStatus.of(status, **{name: status.details.get(name) for name in _DEVICE})
            for status in processes.statuses(session)
        ],
        disk_free_bytes=shutil.disk_usage(settings.data).free,
        data_bytes=use.total_bytes,
        storage=Storage.of(use, cache_limit_bytes=settings.cache_limit_bytes),
        has_example=has_example(),
    )


@joining_router.post("/workers", responses=CONFLICT)
def let_worker_in(request: Request, identity: Who, worker: WorkerJoining) -> SharedPlaces:
    """Tell a worker of another machine where database, queue and files of runs are.

    Only a worker's key may ask: the answer has whatever credentials the addresses contain.
    """
    server_version = (__version__, schema_revision())
    if (worker.version, worker.revision) != server_version:
        raise Conflict(
            f"This server is version {server_version[0]} with schema {server_version[1]}, the"
            f" worker is version {worker.version} with schema {worker.revision}. Install the"
            " server's version on the worker's machine."
        )
    services = services_of(request)
    refuse_unshared(services.settings)
    path, content = probe_of(identity)
    if not services.artifacts.exists(path):
        services.artifacts.put(path, content.encode())
    # Not before: nobody else could write while the artifact store is slow.
    with services.database.writing() as session:
        audit.note(
            session, audit.Action.WORKER_LET_IN, identity.player_id, f"key {identity.credential_id}"
        )
    return SharedPlaces(
        database_url=services.settings.application_url,
        jobs_database_url=services.settings.queue_url,
        artifacts_url=services.artifacts.url,
        probe_path=path,
        probe=content,
    )
