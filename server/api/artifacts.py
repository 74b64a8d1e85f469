"""The files of trainings, and a whole training as one file."""

from __future__ import annotations

from fastapi import APIRouter, Request
from starlette.responses import Response

from server.dependencies import ArtifactId, RunId, Who, services_of
from server.web.problems import CONFLICT, NOT_FOUND
from tril.store import audit, behaviours
from tril.store.models import BehaviourRow, RunRow
from tril.store.training import artifacts, runs

router = APIRouter(prefix="/artifacts", tags=["artifacts"])
archive_router = APIRouter(tags=["artifacts"])

_ZIP = "application/zip"


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
    services = services_of(request)
    with services.database.reading() as session:
        run = runs.get_done(session, str(run_id))
        behaviour = behaviours.get(session, run.behaviour_id)
    archive = services.archives.archive(run, behaviour)
    with services.database.writing() as session:
        audit.note(session, audit.Action.EXPORTED, identity.player_id, f"run {run.id}")
    return Response(
        archive,
        media_type=_ZIP,
        headers={
            "Cache-Control": "private, no-cache",
            "Content-Disposition": f'attachment; filename="{archive_name(run, behaviour)}"',
        },
    )


def archive_name(run: RunRow, behaviour: BehaviourRow) -> str:
    """Return the file name of a training's archive."""
    return f"tril-{behaviour.slug}-{run.id[:8]}.zip"
