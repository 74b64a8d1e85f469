"""The blind comparison of a training's games."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Path, Request
from sqlalchemy.orm import Session
from starlette.responses import Response

from server.api.schemas.blind import (
    BlindAnswerNew,
    BlindComparison,
    BlindSide,
    FinishedBlindRound,
    RevealedPair,
)
from server.api.views.recordings import RecordingViews
from server.dependencies import ReadSession, RunId, Who, WriteSession, services_of
from server.play.replays import ReplayTask
from server.web.problems import CONFLICT, NOT_FOUND
from tril.analysis.blind import MAX_PAIRS, MAX_ROUND, blind_result
from tril.errors import NotFound
from tril.store import recordings
from tril.store.access.credentials import Identity
from tril.store.models import RunRow
from tril.store.training import blind_answers, runs
from tril.store.training.blind_answers import BlindRound

router = APIRouter(prefix="/runs/{run_id}/blind", tags=["runs"])
frames_router = APIRouter(prefix="/runs/{run_id}/blind", tags=["runs"])
"""Routes that replay games."""

_BYTES = "application/octet-stream"


@router.get("", responses=NOT_FOUND)
def get_blind_comparison(session: ReadSession, who: Who, run_id: RunId) -> BlindComparison:
    """Return the reader's answers, and who played which game in finished rounds."""
    return _view(session, who, runs.get(session, str(run_id)))


@router.post("/answers", responses=NOT_FOUND | CONFLICT)
def answer_blind(
    session: WriteSession, who: Who, run_id: RunId, new: BlindAnswerNew
) -> BlindComparison:
    """Judge the next pair of the round, take the last judgement back, or end the round."""
    blind_answers.answer(session, str(run_id), who.player_id, new.round, new.pair, new.answer)
    return _view(session, who, runs.get(session, str(run_id)))


@frames_router.get(
    "/{round_number}/{pair}/{side}/frames",
    response_class=Response,
    responses=NOT_FOUND | {200: {"content": {_BYTES: {}}, "description": "docs/protocol.md"}},
)
def get_blind_frames(
    request: Request,
    run_id: RunId,
    round_number: Annotated[int, Path(ge=1, le=MAX_ROUND)],
    pair: Annotated[int, Path(ge=1, le=MAX_PAIRS)],
    side: BlindSide,
) -> Response:
    """Return every frame of a game in a round, without naming the game."""
    services = services_of(request)
    with services.database.reading() as session:
        pairs = blind_answers.pairs_of(session, runs.get(session, str(run_id)), round_number)
        if pair > len(pairs):
            raise NotFound("There is no such pair.")
        recording_id = pairs[pair - 1].sides[0 if side == "left" else 1]
        recording = recordings.as_recording(recordings.get(session, recording_id))
    frames = services.replay_cache.get(recording, ReplayTask.FRAMES)
    return Response(frames, media_type=_BYTES, headers={"Cache-Control": "private, no-cache"})


def _view(session: Session, who: Identity, run: RunRow) -> BlindComparison:
    finished, current = blind_answers.own_rounds(
        blind_answers.rounds_of(session, run.id), who.player_id
    )
    return BlindComparison(
        round=current.number,
        n_pairs=len(blind_answers.pairs_of(session, run, current.number)),
        answers=[pair.answer for pair in current.judged],
        frames_url=f"/api/runs/{run.id}/blind/{current.number}/{{pair}}/{{side}}/frames",
        finished=_finished(session, who, run, finished),
    )


def _finished(
    session: Session, who: Identity, run: RunRow, rounds: list[BlindRound]
) -> list[FinishedBlindRound]:
    views = RecordingViews(session, who, run.behaviour_id)
    ids = {key for blind_round in rounds for pair in blind_round.judged for key in pair.sides}
    rows = recordings.by_ids(session, ids)
    shown = {key: views.view(row) for key, row in rows.items()}
    return [
        FinishedBlindRound(
            number=blind_round.number,
            result=result,
            pairs=[
                RevealedPair.of(pair, imitator=shown[pair.imitator_id], other=shown[pair.other_id])
                for pair in blind_round.judged
            ],
        )
        for blind_round in reversed(rounds)
        if (result := blind_result([blind_round.judged])) is not None
    ]
