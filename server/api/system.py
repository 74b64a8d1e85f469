"""The processes and the disk usage."""

from __future__ import annotations

import shutil

from fastapi import APIRouter, Request

from server.api.schemas.system import ProcessStatus, Storage, System
from server.dependencies import ReadSession, services_of
from tril import __version__
from tril.exchange.example import has_example
from tril.store import processes

router = APIRouter(tags=["system"])


@router.get("/system")
def get_system(request: Request, session: ReadSession) -> System:
    """Return the state of the processes and the disk usage."""
    services = services_of(request)
    settings, use = services.settings, services.storage.use()
    return System(
        version=__version__,
        processes=[ProcessStatus.model_validate(found) for found in processes.statuses(session)],
        disk_free_bytes=shutil.disk_usage(settings.data).free,
        data_bytes=use.total_bytes,
        storage=Storage.of(use, cache_limit_bytes=settings.cache_limit_bytes),
        has_example=has_example(),
    )
