"""Whether Tril is well."""

from __future__ import annotations

import shutil
from dataclasses import asdict
from importlib.metadata import version

from fastapi import APIRouter, Request

from server.api.schemas import Health, ProcessStatus, Storage, System
from server.dependencies import Reading, services_of
from tril.store import processes

router = APIRouter(tags=["system"])


@router.get("/health", response_model_exclude_none=True)
async def get_health(request: Request) -> Health:
    """Say that the server answers, and which of its background tasks fail. Needs no cookie."""
    tasks = services_of(request).games.background_tasks
    failing = [task.name for task in tasks if not task.is_healthy]
    return Health(status="degraded", failing=failing) if failing else Health(status="ok")


@router.get("/system")
def get_system(request: Request, session: Reading) -> System:
    """Return which processes live and how much room there is."""
    services = services_of(request)
    settings, use = services.settings, services.storage.use()
    return System(
        version=version("tril"),
        processes=[ProcessStatus(**asdict(found)) for found in processes.statuses(session)],
        disk_free_bytes=shutil.disk_usage(settings.data).free,
        data_bytes=use.total_bytes,
        storage=Storage(
            databases_bytes=use.databases_bytes,
            artifacts_bytes=use.artifacts_bytes,
            cache_bytes=use.cache_bytes,
            cache_limit_bytes=settings.cache_limit_bytes,
            other_bytes=use.other_bytes,
        ),
    )
