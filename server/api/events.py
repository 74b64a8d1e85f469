"""The change stream as server-sent events."""

from __future__ import annotations

from fastapi import APIRouter, Request
from starlette.responses import StreamingResponse

from server.dependencies import services_of

router = APIRouter(tags=["events"])


@router.get(
    "/events",
    response_class=StreamingResponse,
    responses={
        200: {
            "content": {"text/event-stream": {"schema": {"type": "string"}}},
            "description": 'Events named "change" with data {"topic", "key"}: what to load again. '
            "A comment every 15 s keeps the connection open.",
        }
    },
)
async def stream_events(request: Request) -> StreamingResponse:
    """Stream changes from now on."""
    return StreamingResponse(
        services_of(request).changes.stream(),
        media_type="text/event-stream",
        headers={"Cache-Control": "no-store", "X-Accel-Buffering": "no"},
    )
