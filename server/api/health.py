"""Whether the server answers."""

from __future__ import annotations

from fastapi import APIRouter

from server.api.schemas.system import Health

router = APIRouter(tags=["system"])


@router.get("/health")
async def get_health() -> Health:
    """Say that the server answers, whatever its database is busy with. Needs no cookie."""
    return Health(status="ok")
