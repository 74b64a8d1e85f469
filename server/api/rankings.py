"""The ranking of a behaviour's recordings and its revisions."""

from __future__ import annotations

from fastapi import APIRouter, Request
from sqlalchemy.orm import Session
from starlette.concurrency import run_in_threadpool
from starlette.responses import JSONResponse, Response

from server.api.schemas.rankings import (
    Ranking,
    RankingConflict,
    RankingRevision,
    RankingStep,
    RankingUpdate,
)
from server.dependencies import BehaviourId, ReadSession, WriteSession, services_of
from server.web.problems import NOT_FOUND
from tril.store import behaviours, players, rankings
from tril.store.models import RankingRow

router = APIRouter(prefix="/behaviours/{behaviour_id}/ranking", tags=["ranking"])

_CONFLICT: dict[int | str, dict[str, object]] = {
    409: {"model": RankingConflict, "description": "Somebody saved another ranking first."}
}


@router.get("", responses=NOT_FOUND)
def get_ranking(session: ReadSession, behaviour_id: BehaviourId) -> Ranking:
    """Return the current ranking."""
    behaviours.get(session, behaviour_id)
    return _view(session, rankings.current(session, behaviour_id))


@router.put("", responses=NOT_FOUND | _CONFLICT)
def save_ranking(
    session: WriteSession, behaviour_id: BehaviourId, update: RankingUpdate
) -> Ranking:
    """Save a ranking."""
    behaviours.get(session, behaviour_id)
    player = players.owner(session)
    row = rankings.save(session, behaviour_id, update.base_revision, update.tiers, player.id)
    return _view(session, row)


@router.post("/undo", responses=NOT_FOUND | _CONFLICT)
def undo_ranking(session: WriteSession, behaviour_id: BehaviourId, step: RankingStep) -> Ranking:
    """Undo the last change."""
    behaviours.get(session, behaviour_id)
    player = players.owner(session)
    return _view(session, rankings.undo(session, behaviour_id, step.base_revision, player.id))


@router.post("/redo", responses=NOT_FOUND | _CONFLICT)
def redo_ranking(session: WriteSession, behaviour_id: BehaviourId, step: RankingStep) -> Ranking:
    """Redo the change that was undone last."""
    behaviours.get(session, behaviour_id)
    player = players.owner(session)
    return _view(session, rankings.redo(session, behaviour_id, step.base_revision, player.id))


@router.get("/revisions", responses=NOT_FOUND)
def list_ranking_revisions(
    session: ReadSession, behaviour_id: BehaviourId
) -> list[RankingRevision]:
    """Return the revisions of the ranking, newest first."""
    behaviours.get(session, behaviour_id)
    names = players.names(session)
    return [
        RankingRevision.of(row, player=names.get(row.player_id or 0))
        for row in rankings.revisions(session, behaviour_id)
    ]


async def on_conflict(request: Request, error: Exception) -> Response:
    """Answer a change of an old revision with both rankings."""
    assert isinstance(error, rankings.RankingConflict)
    body = await run_in_threadpool(_conflict, request, error)
    return JSONResponse(body, status_code=409)


def _conflict(request: Request, error: rankings.RankingConflict) -> dict[str, object]:
    with services_of(request).database.reading() as session:
        current = _view(session, rankings.current(session, error.behaviour_id))
    yours = current.tiers if error.yours is None else [list(tier) for tier in error.yours]
    conflict = RankingConflict(detail=str(error), current=current, yours=yours)
    return conflict.model_dump(mode="json")


def _view(session: Session, row: RankingRow) -> Ranking:
    return Ranking.of(
        row,
        unranked=rankings.unranked(session, row),
        n_pairs=rankings.as_ranking(row).n_pairs,
        can_undo=row.undo_to is not None,
        can_redo=row.redo_to is not None,
    )
