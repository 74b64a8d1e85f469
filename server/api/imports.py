"""Uploads of recordings, and the finished run that ships with Tril."""

from __future__ import annotations

import asyncio
from io import BytesIO
from typing import Annotated

from fastapi import APIRouter, HTTPException, Query, Request
from starlette.concurrency import run_in_threadpool

from server.api.schemas.recordings import ImportResult
from server.api.schemas.runs import Run
from server.api.views.runs import run_view
from server.dependencies import BehaviourId, Who, services_of
from server.web.problems import CONFLICT, NOT_FOUND
from tril.exchange.example import open_example
from tril.exchange.recording_transfer import RecordingImportResult, import_recordings
from tril.store.training import runs

router = APIRouter(tags=["recordings"])

MAX_IMPORTED = 200
"""Most recordings in one upload: each is replayed, which takes about 0.1 s."""

UPLOAD_TIMEOUT_S = 120
"""How long a body may take to arrive while other uploads wait: 16 MiB at 1 Mbit/s."""


@router.post(
    "/behaviours/{behaviour_id}/recordings/import",
    responses=NOT_FOUND | CONFLICT,
    openapi_extra={
        "requestBody": {
            "required": True,
            "description": "Recordings in the exchange format or action lists: one object, or JSON"
            " Lines.",
            # Each line is judged on its own, and the answer says which were refused.
            "content": {"application/x-ndjson": {"schema": {}}, "application/json": {"schema": {}}},
        }
    },
)
async def import_recordings_file(
    request: Request,
    identity: Who,
    behaviour_id: BehaviourId,
    rank: Annotated[bool, Query(description="The order is from best to worst.")] = False,
    perfect: Annotated[bool, Query(description="All are perfect.")] = False,
) -> ImportResult:
    """Verify uploaded recordings and add those that replay; say why others are refused."""
    content = BytesIO()
    try:
        async with asyncio.timeout(UPLOAD_TIMEOUT_S):
            # Joined at its end, 16 MiB would take the event loop 10 ms.
            async for part in request.stream():
                content.write(part)
    except TimeoutError:
        raise HTTPException(408, "The upload took too long. Try again.") from None
    services = services_of(request)
    database = services.database

    def add() -> RecordingImportResult:
        content.seek(0)
        with content:
            return import_recordings(
                database,
                behaviour_id,
                content,
                rank=rank,
                perfect=perfect,
                player_id=identity.player_id,
                max_recordings=MAX_IMPORTED,
                max_of_player=services.settings.max_recordings_per_player,
                # A console that is loaded in a thread keeps all games waiting for 0.1 s.
                load=services.replays.load,
            )

    imported = await run_in_threadpool(add)
    return ImportResult.of(imported, imported=imported.recording_ids)


@router.post("/example", responses=NOT_FOUND | CONFLICT)
def open_finished_example(request: Request, identity: Who) -> Run:
    """Import the finished training that ships with Tril, once, and return it.

    It is restored if it was deleted.
    """
    services = services_of(request)
    opened = open_example(services.database, services.artifacts, identity.player_id)
    with services.database.reading() as session:
        return run_view(session, runs.get(session, opened.run_id))
