"""The library of recordings: list, keep, delete, mark and export."""

from __future__ import annotations

import json
import os
import tempfile
from contextlib import suppress
from typing import Annotated, Any, Literal

from fastapi import APIRouter, BackgroundTasks, Query, Request
from sqlalchemy.orm import Session
from starlette.background import BackgroundTask
from starlette.responses import FileResponse, Response

from server.api.schemas.library import Library
from server.api.schemas.recordings import (
    Branch,
    ChosenRecordings,
    MemoryCell,
    Recording,
    RecordingCourse,
    RecordingsChange,
    RecordingUpdate,
)
from server.api.views.library import library_response
from server.api.views.recordings import RecordingViews, parent_of
from server.dependencies import (
    MAX_ID,
    MAX_LISTED,
    BehaviourId,
    PageLimit,
    ReadSession,
    RecordingId,
    Who,
    WriteSession,
    services_of,
)
from server.replay_cache import version_of
from server.services import Services
from server.web.permissions import RESEARCHERS_MEMBERS
from server.web.problems import CONFLICT, NOT_FOUND
from tril.errors import NotFound
from tril.exchange import recording_transfer
from tril.games import UnknownGame, game_of
from tril.games.behaviours import Behaviour
from tril.store import audit, behaviours, library, recordings
from tril.store.access.credentials import Identity
from tril.store.models import RecordingRow
from tril.text import shown_json

router = APIRouter(tags=["recordings"])

JSON_LINES = "application/x-ndjson"
_LINES = {"schema": {"type": "string"}}

MAX_SHOWN = 100
"""Most recordings that one request names in its address."""
MAX_NAMED = 20
"""Most recordings that a refusal names."""

_CHANGED = (
    RecordingRow.behaviour_id,
    RecordingRow.run_id,
    RecordingRow.number,
    RecordingRow.state,
    RecordingRow.verification,
    RecordingRow.verification_note,
    RecordingRow.perfect,
    RecordingRow.deleted_at,
)
"""All that a change of many recordings reads of each."""


@router.get("/behaviours/{behaviour_id}/recordings", responses=NOT_FOUND)
def list_recordings(
    session: ReadSession,
    identity: Who,
    behaviour_id: BehaviourId,
    include: Annotated[list[Literal["deleted", "policy"]] | None, Query(max_length=2)] = None,
    before: Annotated[
        int | None, Query(ge=1, le=MAX_ID, description="Only those with lower ids.")
    ] = None,
    limit: PageLimit = MAX_LISTED,
    undecided: Annotated[bool, Query(description="Only those to keep or discard.")] = False,
) -> list[Recording]:
    """Return a behaviour's recordings, newest first, those to keep or discard included.

    At most 200 are returned: ask for further ones with ``before``. A participant gets their own.
    """
    behaviours.get(session, behaviour_id)
    included = include or []
    rows = recordings.listing(
        session,
        behaviour_id,
        with_deleted="deleted" in included,
        with_policies="policy" in included,
        with_undecided=True,
        only_of=identity.visible_player_id,
        undecided_only=undecided,
        before=before,
        limit=limit,
    )
    return RecordingViews(session, identity).all(rows)


@router.get(
    "/behaviours/{behaviour_id}/library",
    response_model=Library,
    responses=NOT_FOUND,
)
def get_library(
    session: ReadSession,
    identity: Who,
    behaviour_id: BehaviourId,
    since: Annotated[
        int | None,
        Query(ge=0, le=MAX_ID, description="Only what changed after an answer's `cursor`."),
    ] = None,
    before: Annotated[
        int | None,
        Query(ge=1, le=MAX_ID, description="Only those with lower ids; not of what changed."),
    ] = None,
    limit: Annotated[
        int | None, Query(ge=1, le=MAX_ID, description="At most so many; not of what changed.")
    ] = None,
    deleted: Annotated[bool, Query(description="With deleted ones.")] = False,
) -> Response:
    """Return all of a behaviour's recordings in brief, newest first, a part, or what changed.

    A participant gets their own, and is not told what is ranked or perfect.
    """
    behaviour = behaviours.get(session, behaviour_id)
    brief = library.brief(
        session,
        behaviour_id,
        since=since,
        before=before,
        limit=limit,
        with_deleted=deleted,
        only_of=identity.visible_player_id,
    )
    return library_response(session, identity, behaviour, brief)


@router.get("/behaviours/{behaviour_id}/library/recordings", responses=NOT_FOUND)
def list_shown_recordings(
    session: ReadSession,
    identity: Who,
    behaviour_id: BehaviourId,
    recording: Annotated[list[RecordingId], Query(min_length=1, max_length=MAX_SHOWN)],
) -> list[Recording]:
    """Return some recordings of a behaviour, or borrowed by it, as they are shown for it.

    Deleted ones are returned, too; those that are neither are left out. A participant gets their
    own.
    """
    behaviours.get(session, behaviour_id)
    rows = library.shown(session, behaviour_id, recording, identity.visible_player_id)
    return RecordingViews(session, identity, behaviour_id).all(rows)


@router.post(
    "/behaviours/{behaviour_id}/recordings/change",
    status_code=204,
    responses=NOT_FOUND | CONFLICT,
)
def change_recordings(
    session: WriteSession, identity: Who, behaviour_id: BehaviourId, body: RecordingsChange
) -> None:
    """Delete, restore or mark several recordings, all or none."""
    rows = _of_behaviour(session, behaviour_id, body.recording_ids, *_CHANGED)
    if body.change == "delete":
        recordings.delete(session, rows, identity.player_id)
    elif body.change == "restore":
        recordings.restore(session, rows, identity.player_id)
    else:
        perfect = body.change == "mark_perfect"
        recordings.mark(session, rows, perfect, identity.player_id)


@router.get(
    "/behaviours/{behaviour_id}/recordings/export",
    response_class=Response,
    responses=NOT_FOUND | {200: {"content": {JSON_LINES: _LINES}}},
)
def export_recordings(
    request: Request,
    session: ReadSession,
    identity: Who,
    behaviour_id: BehaviourId,
    recording: Annotated[
        list[RecordingId] | None, Query(max_length=500, description="Only these.")
    ] = None,
) -> Response:
    """Return a behaviour's recordings as JSON Lines, ranked ones first from best to worst."""
    return _exported(request, session, identity, behaviour_id, recording)


@router.post(
    "/behaviours/{behaviour_id}/recordings/export",
    response_class=Response,
    responses=NOT_FOUND | {200: {"content": {JSON_LINES: _LINES}}},
)
def export_chosen_recordings(
    request: Request,
    session: ReadSession,
    identity: Who,
    behaviour_id: BehaviourId,
    chosen: ChosenRecordings,
) -> Response:
    """Return recordings of a behaviour as JSON Lines: more than an address can name."""
    return _exported(request, session, identity, behaviour_id, chosen.recording_ids)


def _exported(
    request: Request, session: Session, identity: Identity, behaviour_id: int, ids: list[int] | None
) -> Response:
    row = behaviours.get(session, behaviour_id)
    if ids is not None:
        _of_behaviour(session, behaviour_id, ids, RecordingRow.behaviour_id)
    descriptor, name = tempfile.mkstemp(prefix="tril-export-", suffix=".jsonl")
    n_written = 0
    try:
        # A library's file may be larger than what a server should hold in memory.
        with os.fdopen(descriptor, "w") as file:
            for item in recording_transfer.export_recordings(session, behaviour_id, ids):
                file.write(f"{json.dumps(item)}\n")
                n_written += 1
        _note_export(request, identity, f"behaviour {behaviour_id}", recordings=n_written)
    except BaseException:
        os.unlink(name)
        raise
    return FileResponse(
        name,
        media_type=JSON_LINES,
        headers=_download(f"{row.slug}.jsonl"),
        background=BackgroundTask(os.unlink, name),
    )


@router.get("/recordings/{recording_id}", responses=NOT_FOUND)
def get_recording(session: ReadSession, identity: Who, recording_id: RecordingId) -> Recording:
    """Return a recording, even a deleted one."""
    return RecordingViews(session, identity).view(recordings.get(session, recording_id))


@router.patch("/recordings/{recording_id}", responses=NOT_FOUND | CONFLICT)
def update_recording(
    session: WriteSession, identity: Who, recording_id: RecordingId, update: RecordingUpdate
) -> Recording:
    """Mark a recording as perfect or not, or change its notes."""
    row = recordings.get(session, recording_id)
    recordings.update(session, row, update.perfect, update.notes, identity.player_id)
    return RecordingViews(session, identity).view(row)


@router.delete("/recordings/{recording_id}", status_code=204, responses=NOT_FOUND | CONFLICT)
def delete_recording(session: WriteSession, identity: Who, recording_id: RecordingId) -> None:
    """Delete a recording; it can be restored."""
    row = recordings.get(session, recording_id)
    recordings.delete(session, [row], identity.player_id)


@router.post("/recordings/{recording_id}/keep", responses=NOT_FOUND | CONFLICT)
def keep_recording(
    request: Request,
    background: BackgroundTasks,
    session: WriteSession,
    identity: Who,
    recording_id: RecordingId,
) -> Recording:
    """Put a finished game into the library.

    Where it is to be ranked by statements, Tril learns to see the game while more are played.
    """
    row = recordings.get(session, recording_id)
    recordings.keep(session, row)
    behaviour = behaviours.as_behaviour(behaviours.get(session, row.behaviour_id))
    if behaviour.target is None:
        background.add_task(_learn_to_see, services_of(request), behaviour)
    return RecordingViews(session, identity).view(row)


def _learn_to_see(services: Services, behaviour: Behaviour) -> None:
    # A game whose package is gone has nothing more to be seen.
    with suppress(UnknownGame):
        services.vocabularies.vocabulary(game_of(behaviour))


@router.post("/recordings/{recording_id}/discard", responses=NOT_FOUND | CONFLICT)
def discard_recording(session: WriteSession, identity: Who, recording_id: RecordingId) -> Recording:
    """Delete a recording and return it; it can be restored."""
    row = recordings.get(session, recording_id)
    recordings.delete(session, [row], identity.player_id)
    return RecordingViews(session, identity).view(row)


@router.post("/recordings/{recording_id}/restore", responses=NOT_FOUND | CONFLICT)
def restore_recording(session: WriteSession, identity: Who, recording_id: RecordingId) -> Recording:
    """Restore a deleted recording, in the rankings too."""
    row = recordings.get(session, recording_id)
    recordings.restore(session, [row], identity.player_id)
    return RecordingViews(session, identity).view(row)


@router.get("/recordings/{recording_id}/course", responses=NOT_FOUND)
def get_recording_course(
    session: ReadSession, identity: Who, recording_id: RecordingId
) -> RecordingCourse:
    """Return the action of every frame, and the recordings that this one is related to."""
    row = recordings.get(session, recording_id)
    recording = recordings.as_recording(row)
    names = sorted(recording.game.memory_names.items())
    return RecordingCourse(
        actions=list(row.actions),
        parent=parent_of(session, identity, row),
        branches=[
            Branch(recording_id=branch.id, number=branch.number, frame=branch.parent_frame)
            for branch in recordings.branches(session, row.id, identity.visible_player_id)
            if branch.parent_frame is not None
        ],
        conditions=shown_json(row.conditions),
        memory_url=f"/api/recordings/{row.id}/memory?v={version_of(recording)}",
        memory_names=[MemoryCell(address=address, name=name) for address, name in names],
    )


@router.get(
    "/recordings/{recording_id}/export",
    response_class=Response,
    responses=NOT_FOUND | {200: {"content": {"application/json": {"schema": {"type": "object"}}}}},
)
def export_recording(
    request: Request, session: ReadSession, identity: Who, recording_id: RecordingId
) -> Response:
    """Return a recording in the exchange format.

    A participant gets it as it was played, without its place in the ranking, mark and notes.
    """
    row = recordings.get(session, recording_id)
    content = recording_transfer.export_recording(session, row)
    if identity.is_participant:
        content = {key: content[key] for key in content.keys() - RESEARCHERS_MEMBERS}
    _note_export(request, identity, f"recording {row.id}", **audit.of_recording(row))
    return Response(
        json.dumps(content, indent=2),
        media_type="application/json",
        headers=_download(f"{recordings.file_name(session, row)}.json"),
    )


def _note_export(request: Request, identity: Identity, subject: str, **details: int | None) -> None:
    """Log an export in a transaction of its own, since what is exported is read in another."""
    with services_of(request).database.writing() as session:
        audit.note(session, audit.Action.EXPORTED, identity.player_id, subject, **details)


def _of_behaviour(
    session: Session, behaviour_id: int, ids: list[int], *columns: Any
) -> list[RecordingRow]:
    """Return recordings of a behaviour, sorted by id; raises NotFound with the ids missing."""
    behaviours.get(session, behaviour_id)
    rows = recordings.by_ids(session, ids, *columns)
    missing = {key for key in ids if key not in rows or rows[key].behaviour_id != behaviour_id}
    if missing:
        names = ", ".join(str(key) for key in sorted(missing)[:MAX_NAMED])
        if len(missing) > MAX_NAMED:
            names += f" and {len(missing) - MAX_NAMED} more"
        raise NotFound(f"These are no recordings of this behaviour: {names}.")
    return [rows[key] for key in sorted(rows)]


def _download(name: str) -> dict[str, str]:
    return {"Content-Disposition": f'attachment; filename="{name}"'}
