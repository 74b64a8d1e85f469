"""The health check."""

from __future__ import annotations

from fastapi import APIRouter

from server.api.schemas.system import Health

router = APIRouter(tags=["system"])


@router.get("/health")
async def get_health() -> Health:
    """Answer that the server runs, without asking the database. Needs no cookie."""
    return Health(status="ok")
