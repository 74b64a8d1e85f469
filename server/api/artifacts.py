"""The files of trainings, and a whole training as one file."""

from __future__ import annotations

from collections.abc import Callable

from fastapi import APIRouter, Request
from starlette.responses import Response

from server.archives import PagePart
from server.dependencies import ArtifactId, RunId, Who, services_of
from server.web.problems import CONFLICT, NOT_FOUND
from tril.store import audit, behaviours, measured
from tril.store.access.credentials import Identity
from tril.store.models import BehaviourRow, RunRow
from tril.store.training import artifacts, blind_answers, runs

router = APIRouter(prefix="/artifacts", tags=["artifacts"])
archive_router = APIRouter(tags=["artifacts"])

_ZIP = "application/zip"
_PAGE_TYPES = {PagePart.PAGE: "text/html; charset=utf-8", PagePart.POSTER: "image/png"}


@router.get(
    "/{artifact_id}",
    response_class=Response,
    responses=NOT_FOUND | {200: {"content": {"*/*": {}}, "description": "The file."}},
)
def get_artifact(request: Request, artifact_id: ArtifactId) -> Response:
    """Return a file of a training."""
    services = services_of(request)
    with services.database.reading() as session:
        row = artifacts.get(session, artifact_id)
    # A run that resumes from a checkpoint may rewrite the file.
    return Response(
        artifacts.read(services.artifacts, row),
        media_type=row.media_type,
        headers={
            "Cache-Control": "private, no-cache",
            "Content-Disposition": f'inline; filename="{row.name}"',
        },
    )


@archive_router.get(
    "/runs/{run_id}/archive.zip",
    response_class=Response,
    responses=NOT_FOUND
    | CONFLICT
    | {200: {"content": {_ZIP: {}}, "description": "docs/run-archive.md"}},
)
def get_run_archive(request: Request, identity: Who, run_id: RunId) -> Response:
    """Return a finished training as one zip; making it takes some seconds the first time."""
    archives = services_of(request).archives
    return _taken_away(request, identity, run_id, "zip", _ZIP, archives.archive)


@archive_router.get(
    "/runs/{run_id}/page.{part}",
    response_class=Response,
    responses=NOT_FOUND
    | CONFLICT
    | {
        200: {
            "content": {media_type: {} for media_type in _PAGE_TYPES.values()},
            "description": "A page that needs no server, or its poster.",
        }
    },
)
def get_run_page(request: Request, identity: Who, run_id: RunId, part: PagePart) -> Response:
    """Return a finished training as one page to send; making it takes some seconds."""
    archives = services_of(request).archives
    return _taken_away(
        request,
        identity,
        run_id,
        part,
        _PAGE_TYPES[part],
        lambda run, behaviour, version: archives.page(run, behaviour, version, part),
    )


def _taken_away(
    request: Request,
    identity: Identity,
    run_id: RunId,
    ending: str,
    media_type: str,
    make: Callable[[RunRow, BehaviourRow, object], bytes],
) -> Response:
    """Return a file of a finished training, and note who took it."""
    database = services_of(request).database
    with database.reading() as session:
        run = runs.get_done(session, str(run_id))
        behaviour = behaviours.get(session, run.behaviour_id)
        # Answers are only ever added; measures are read from replays, one by one.
        n_answers = len(blind_answers.rows_of(session, run.id))
        n_unmeasured = len(measured.unmeasured(session)) if behaviour.measures else 0
    content = make(run, behaviour, (n_answers, n_unmeasured))
    with database.writing() as session:
        audit.note(session, audit.Action.EXPORTED, identity.player_id, f"run {run.id}")
    # Never shown in place: it is another site's page.
    name = f"tril-{behaviour.slug}-{run.id[:8]}.{ending}"
    return Response(
        content,
        media_type=media_type,
        headers={
            "Cache-Control": "private, no-cache",
            "Content-Disposition": f'attachment; filename="{name}"',
        },
    )
