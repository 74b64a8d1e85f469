"""The change stream as server-sent events."""

from __future__ import annotations

from collections.abc import Collection

from fastapi import APIRouter, Request
from starlette.responses import StreamingResponse

from server.change_stream import Change
from server.dependencies import Who, services_of
from tril.store import recordings
from tril.store.changes import LIBRARY_CHANGED

router = APIRouter(tags=["events"])


@router.get(
    "/events",
    response_class=StreamingResponse,
    responses={
        200: {
            "content": {"text/event-stream": {"schema": {"type": "string"}}},
            "description": 'Events named "change" with data {"topic", "key"}: what to load again. '
            'An event named "ping" follows 5 s of silence: without it the connection is lost.',
        }
    },
)
async def stream_events(request: Request, identity: Who) -> StreamingResponse:
    """Stream changes until the listener is signed out or has other rights."""
    services = services_of(request)
    services.access.refuse_too_many_open(identity)

    async def visible_changes(changes: Collection[Change]) -> Collection[Change]:
        played = [int(key) for topic, key in changes if topic == "recording"]
        own_changes = {("player", str(identity.player_id))}
        own_changes |= {
            (topic, str(key))
            for topic in ("behaviour", LIBRARY_CHANGED)
            for key in identity.behaviour_ids
        }
        if played:
            ids = await services.access.query(
                lambda session: recordings.own_ids(
                    session, identity.player_id, identity.behaviour_ids, played
                )
            )
            own_changes |= {("recording", str(key)) for key in ids}
        return [change for change in changes if change in own_changes]

    return StreamingResponse(
        services.changes.stream(
            visible_changes if identity.is_participant else None,
            # A page listens again at once, with the rights that it has then.
            lambda end: services.access.watch_rights(identity, lambda _may_return: end()),
        ),
        media_type="text/event-stream",
        headers={"Cache-Control": "no-store", "X-Accel-Buffering": "no"},
    )
