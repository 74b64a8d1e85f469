"""The files of trainings."""

from __future__ import annotations

from fastapi import APIRouter, Request
from starlette.responses import Response

from server.dependencies import ArtifactId, services_of
from server.web.problems import NOT_FOUND
from tril.store.training import artifacts

router = APIRouter(prefix="/artifacts", tags=["artifacts"])


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
        services.artifacts.get(row.path),
        media_type=row.media_type,
        headers={
            "Cache-Control": "private, no-cache",
            "Content-Disposition": f'inline; filename="{row.name}"',
        },
    )
