"""The health check."""

from __future__ import annotations

from fastapi import APIRouter, Request

from server.api.schemas.system import Health
from server.dependencies import services_of

router = APIRouter(tags=["system"])


@router.get("/health", response_model_exclude_none=True)
async def get_health(request: Request) -> Health:
    """Answer that the server runs, and which of its background tasks fail.

    Asks no database and needs no cookie.
    """
    services = services_of(request)
    tasks = (*services.games.background_tasks, *services.watching.background_tasks)
    failing = [task.name for task in tasks if not task.is_healthy]
    return Health(status="degraded", failing=failing) if failing else Health(status="ok")
