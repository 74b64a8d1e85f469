"""The library of recordings: list, keep, delete, mark, watch, import, export."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Annotated, Literal

from fastapi import APIRouter, Query, Request
from sqlalchemy.orm import Session
from starlette.concurrency import run_in_threadpool
from starlette.responses import Response

from server.api.schemas import (
    Branch,
    ImportResult,
    MemoryCell,
    Recording,
    RecordingCourse,
    RecordingsChange,
    RecordingUpdate,
    Refusal,
)
from server.api.views import RecordingViews, parent_of
from server.clips import MEDIA_TYPES, ClipKind
from server.dependencies import BehaviourId, Reading, RecordingId, Writing, services_of
from server.derived import Derived, version_of
from server.web.problems import CONFLICT, NOT_FOUND
from tril.errors import NotFound
from tril.exchange import recording_transfer
from tril.game.space_invaders import RAM_NAMES
from tril.recording import Recording as Played
from tril.store import behaviours, players, recordings
from tril.store.models import RecordingRow

router = APIRouter(tags=["recordings"])

MAX_IMPORTED = 200
"""Most recordings in one upload: each is replayed, which takes about 0.1 s."""

JSON_LINES = "application/x-ndjson"
_LINES = {"schema": {"type": "string"}}
_FOR_EVER = "private, max-age=31536000, immutable"


@router.get("/behaviours/{behaviour_id}/recordings", responses=NOT_FOUND)
def list_recordings(
    session: Reading,
    behaviour_id: BehaviourId,
    include: Annotated[list[Literal["deleted", "policy"]] | None, Query(max_length=2)] = None,
) -> list[Recording]:
    """Return a behaviour's recordings, newest first."""
    behaviours.get(session, behaviour_id)
    wanted = include or []
    rows = recordings.listing(
        session,
        behaviour_id,
        with_deleted="deleted" in wanted,
        with_policies="policy" in wanted,
    )
    return RecordingViews(session).all(rows)


@router.post("/behaviours/{behaviour_id}/recordings/change", responses=NOT_FOUND | CONFLICT)
def change_recordings(
    session: Writing, behaviour_id: BehaviourId, wanted: RecordingsChange
) -> list[Recording]:
    """Delete, restore or mark several recordings, all or none, and return them."""
    rows = _of_behaviour(session, behaviour_id, wanted.recording_ids)
    if wanted.change == "delete":
        recordings.delete_all(session, rows, players.owner(session).id)
    else:
        for row in rows:
            if wanted.change == "restore":
                recordings.restore(session, row)
            else:
                recordings.update(session, row, perfect=wanted.change == "mark_perfect")
    return RecordingViews(session).all(rows)


@router.post(
    "/behaviours/{behaviour_id}/recordings/import",
    responses=NOT_FOUND | CONFLICT,
    openapi_extra={
        "requestBody": {
            "required": True,
            "description": "Recordings in the exchange format: one object, or JSON Lines.",
            # Each line is judged on its own, and the answer says which were refused.
            "content": {JSON_LINES: {"schema": {}}, "application/json": {"schema": {}}},
        }
    },
)
async def import_recordings_file(
    request: Request,
    behaviour_id: BehaviourId,
    rank: Annotated[bool, Query(description="The order is from best to worst.")] = False,
    perfect: Annotated[bool, Query(description="All are perfect.")] = False,
) -> ImportResult:
    """Verify uploaded recordings and add those that replay; say why others are refused."""
    content = await request.body()
    services = services_of(request)

    def add() -> recording_transfer.RecordingImportResult:
        with services.database.reading() as session:
            behaviours.get(session, behaviour_id)
            player_id = players.owner(session).id
        return recording_transfer.import_recordings(
            services.database,
            behaviour_id,
            content,
            rank=rank,
            perfect=perfect,
            player_id=player_id,
            max_recordings=MAX_IMPORTED,
        )

    async with services.importing:
        imported = await run_in_threadpool(add)
    return ImportResult(
        imported=list(imported.recording_ids),
        notices=[Refusal.model_validate(remark) for remark in imported.notices],
        refusals=[Refusal.model_validate(remark) for remark in imported.refusals],
    )


@router.get(
    "/behaviours/{behaviour_id}/recordings/export",
    response_class=Response,
    responses=NOT_FOUND | {200: {"content": {JSON_LINES: _LINES}}},
)
def export_recordings(
    session: Reading,
    behaviour_id: BehaviourId,
    recording: Annotated[
        list[RecordingId] | None, Query(max_length=500, description="Only these.")
    ] = None,
) -> Response:
    """Return a behaviour's recordings as JSON Lines, ranked ones first from best to worst."""
    row = behaviours.get(session, behaviour_id)
    only = None if recording is None else _of_behaviour(session, behaviour_id, recording)
    items = recording_transfer.export_recordings(session, behaviour_id, only)
    return Response(
        "".join(f"{json.dumps(item)}\n" for item in items),
        media_type=JSON_LINES,
        headers=_download(f"{row.slug}.jsonl"),
    )


@router.get("/recordings/{recording_id}", responses=NOT_FOUND)
def get_recording(session: Reading, recording_id: RecordingId) -> Recording:
    """Return one recording, a deleted one too."""
    return RecordingViews(session).one(recordings.get(session, recording_id))


@router.patch("/recordings/{recording_id}", responses=NOT_FOUND)
def update_recording(
    session: Writing, recording_id: RecordingId, update: RecordingUpdate
) -> Recording:
    """Mark a recording as perfect or not, or change its notes."""
    row = recordings.get(session, recording_id)
    recordings.update(session, row, update.perfect, update.notes)
    return RecordingViews(session).one(row)


@router.delete("/recordings/{recording_id}", status_code=204, responses=NOT_FOUND | CONFLICT)
def delete_recording(session: Writing, recording_id: RecordingId) -> None:
    """Delete a recording; it can be restored."""
    row = recordings.get(session, recording_id)
    recordings.delete(session, row, players.owner(session).id)


@router.post("/recordings/{recording_id}/keep", responses=NOT_FOUND | CONFLICT)
def keep_recording(session: Writing, recording_id: RecordingId) -> Recording:
    """Put a finished game into the library."""
    row = recordings.get(session, recording_id)
    recordings.keep(session, row)
    return RecordingViews(session).one(row)


@router.post("/recordings/{recording_id}/discard", responses=NOT_FOUND | CONFLICT)
def discard_recording(session: Writing, recording_id: RecordingId) -> Recording:
    """Delete a recording as DELETE does, and return it; it can be restored."""
    row = recordings.get(session, recording_id)
    recordings.delete(session, row, players.owner(session).id)
    return RecordingViews(session).one(row)


@router.post("/recordings/{recording_id}/restore", responses=NOT_FOUND | CONFLICT)
def restore_recording(session: Writing, recording_id: RecordingId) -> Recording:
    """Bring a deleted recording back, unranked."""
    row = recordings.get(session, recording_id)
    recordings.restore(session, row)
    return RecordingViews(session).one(row)


Version = Annotated[str | None, Query(max_length=40, description="Makes the answer cacheable.")]


@router.get(
    "/recordings/{recording_id}/frames",
    response_class=Response,
    responses=NOT_FOUND
    | {200: {"content": {"application/octet-stream": {}}, "description": "docs/protocol.md"}},
)
def get_recording_frames(
    request: Request, recording_id: RecordingId, v: Version = None
) -> Response:
    """Return every frame of a recording, as docs/protocol.md describes."""
    return _derive(request, recording_id, v, Derived.frames, "application/octet-stream")


@router.get(
    "/recordings/{recording_id}/thumbnail.png",
    response_class=Response,
    responses=NOT_FOUND | {200: {"content": {"image/png": {}}}},
)
def get_recording_thumbnail(
    request: Request, recording_id: RecordingId, v: Version = None
) -> Response:
    """Return a picture of the moment after a recording's last hit, else of its last frame."""
    return _derive(request, recording_id, v, Derived.thumbnail, "image/png")


@router.get("/recordings/{recording_id}/course", responses=NOT_FOUND)
def get_recording_course(session: Reading, recording_id: RecordingId) -> RecordingCourse:
    """Return what was done in every frame, and which recordings this one is related to."""
    row = recordings.get(session, recording_id)
    return RecordingCourse(
        actions=list(row.actions),
        parent=parent_of(row),
        branches=[
            Branch(recording_id=branch.id, frame=branch.parent_frame)
            for branch in recordings.branches(session, row.id)
            if branch.parent_frame is not None
        ],
        conditions=row.conditions,
        memory_url=f"/api/recordings/{row.id}/memory?v={version_of(recordings.as_recording(row))}",
        memory_names=[
            MemoryCell(address=address, name=name) for address, name in sorted(RAM_NAMES.items())
        ],
    )


@router.get(
    "/recordings/{recording_id}/memory",
    response_class=Response,
    responses=NOT_FOUND | {200: {"content": {"application/octet-stream": {}}}},
)
def get_recording_memory(
    request: Request, recording_id: RecordingId, v: Version = None
) -> Response:
    """Return the RAM at the start and after every frame of a recording, 128 bytes each."""
    return _derive(request, recording_id, v, Derived.memory, "application/octet-stream")


@router.get(
    "/recordings/{recording_id}/clip.{kind}",
    response_class=Response,
    responses=NOT_FOUND | {200: {"content": {media: {} for media in MEDIA_TYPES.values()}}},
)
def get_recording_clip(
    request: Request, recording_id: RecordingId, kind: ClipKind, v: Version = None
) -> Response:
    """Return a recording as a moving picture; making it takes seconds the first time."""
    answer = _derive(
        request, recording_id, v, lambda derived, one: derived.clip(one, kind), MEDIA_TYPES[kind]
    )
    answer.headers.update(_download(f"recording-{recording_id}.{kind}"))
    return answer


@router.get(
    "/recordings/{recording_id}/export",
    response_class=Response,
    responses=NOT_FOUND | {200: {"content": {"application/json": {"schema": {"type": "object"}}}}},
)
def export_recording(session: Reading, recording_id: RecordingId) -> Response:
    """Return one recording in the exchange format."""
    row = recordings.get(session, recording_id)
    return Response(
        json.dumps(recording_transfer.export_recording(session, row), indent=2),
        media_type="application/json",
        headers=_download(f"recording-{row.id}.json"),
    )


def _of_behaviour(session: Session, behaviour_id: int, ids: list[int]) -> list[RecordingRow]:
    """Return recordings of a behaviour in the order of their ids; raises NotFound, naming ids."""
    behaviours.get(session, behaviour_id)
    rows = recordings.by_ids(session, ids)
    missing = [key for key in ids if key not in rows or rows[key].behaviour_id != behaviour_id]
    if missing:
        names = ", ".join(str(key) for key in sorted(set(missing)))
        raise NotFound(f"These are no recordings of this behaviour: {names}.")
    return [rows[key] for key in sorted(rows)]


def _derive(
    request: Request,
    recording_id: int,
    version: str | None,
    derive: Callable[[Derived, Played], bytes],
    media_type: str,
) -> Response:
    """Answer with what a recording yields, from the cache where it is there."""
    services = services_of(request)
    with services.database.reading() as session:
        recording = recordings.as_recording(recordings.get(session, recording_id))
    content = derive(services.derived, recording)
    cached = _FOR_EVER if version == version_of(recording) else "private, no-cache"
    return Response(content, media_type=media_type, headers={"Cache-Control": cached})


def _download(name: str) -> dict[str, str]:
    return {"Content-Disposition": f'attachment; filename="{name}"'}
