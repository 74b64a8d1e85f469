"""The order of a behaviour's recordings, every revision kept."""

from __future__ import annotations

from fastapi import APIRouter, Request
from sqlalchemy.orm import Session
from starlette.concurrency import run_in_threadpool
from starlette.responses import JSONResponse, Response

from server.api.schemas import (
    Ranking,
    RankingConflict,
    RankingRevision,
    RankingStep,
    RankingUpdate,
)
from server.dependencies import BehaviourId, Reading, Writing, services_of
from server.web.problems import NOT_FOUND
from tril.store import behaviours, players, rankings
from tril.store.models import RankingRow

router = APIRouter(prefix="/behaviours/{behaviour_id}/ranking", tags=["ranking"])

_CONFLICT: dict[int | str, dict[str, object]] = {
    409: {"model": RankingConflict, "description": "Somebody saved another order first."}
}


@router.get("", responses=NOT_FOUND)
def get_ranking(session: Reading, behaviour_id: BehaviourId) -> Ranking:
    """Return the ranking as it stands."""
    behaviours.get(session, behaviour_id)
    return _shown(session, rankings.current(session, behaviour_id))


@router.put("", responses=NOT_FOUND | _CONFLICT)
def save_ranking(session: Writing, behaviour_id: BehaviourId, update: RankingUpdate) -> Ranking:
    """Save an order."""
    behaviours.get(session, behaviour_id)
    player = players.owner(session)
    row = rankings.save(session, behaviour_id, update.base_revision, update.tiers, player.id)
    return _shown(session, row)


@router.post("/undo", responses=NOT_FOUND | _CONFLICT)
def undo_ranking(session: Writing, behaviour_id: BehaviourId, step: RankingStep) -> Ranking:
    """Bring back the order before the last change."""
    behaviours.get(session, behaviour_id)
    player = players.owner(session)
    return _shown(session, rankings.undo(session, behaviour_id, step.base_revision, player.id))


@router.post("/redo", responses=NOT_FOUND | _CONFLICT)
def redo_ranking(session: Writing, behaviour_id: BehaviourId, step: RankingStep) -> Ranking:
    """Bring back the order that was undone last."""
    behaviours.get(session, behaviour_id)
    player = players.owner(session)
    return _shown(session, rankings.redo(session, behaviour_id, step.base_revision, player.id))


@router.get("/revisions", responses=NOT_FOUND)
def list_ranking_revisions(session: Reading, behaviour_id: BehaviourId) -> list[RankingRevision]:
    """Return what was done to the ranking, newest first."""
    behaviours.get(session, behaviour_id)
    names = players.names(session)
    return [
        RankingRevision(
            revision=row.revision,
            tiers=row.tiers,
            change=row.change,
            player=None if row.player_id is None else names.get(row.player_id),
            created_at=row.created_at,
        )
        for row in rankings.revisions(session, behaviour_id)
    ]


async def on_conflict(request: Request, error: Exception) -> Response:
    """Answer a save on an old revision with both orders."""
    assert isinstance(error, rankings.RankingConflict)
    body = await run_in_threadpool(_conflict, request, error)
    return JSONResponse(body, status_code=409)


def _conflict(request: Request, error: rankings.RankingConflict) -> dict[str, object]:
    with services_of(request).database.reading() as session:
        standing = _shown(session, rankings.current(session, error.behaviour_id))
    yours = standing.tiers if error.yours is None else [list(tier) for tier in error.yours]
    conflict = RankingConflict(detail=str(error), current=standing, yours=yours)
    return conflict.model_dump(mode="json")


def _shown(session: Session, row: RankingRow) -> Ranking:
    return Ranking(
        behaviour_id=row.behaviour_id,
        revision=row.revision,
        tiers=row.tiers,
        unranked=rankings.unranked(session, row),
        n_pairs=rankings.as_ranking(row).n_pairs,
        can_undo=row.undo_to is not None,
        can_redo=row.redo_to is not None,
    )
