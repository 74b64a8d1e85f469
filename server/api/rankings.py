"""The ranking of a behaviour's recordings, its revisions, and the games borrowed for it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from fastapi import APIRouter, Request
from sqlalchemy.orm import Session
from starlette.concurrency import run_in_threadpool
from starlette.responses import JSONResponse, Response

from server.api.schemas.library import Library
from server.api.schemas.rankings import (
    BorrowedGames,
    ContradictingGames,
    GameOpinion,
    NextGame,
    Ranking,
    RankingConflict,
    RankingOpinion,
    RankingStep,
    RankingUpdate,
    ShownOrder,
    StatementAnswerUpdate,
    Understanding,
    UnderstoodStatement,
    VariedGamesWish,
)
from server.api.schemas.recordings import Recording
from server.api.things import picture_url
from server.api.views.library import library_response
from server.api.views.recordings import RecordingViews
from server.dependencies import (
    BehaviourId,
    ReadSession,
    RecordingId,
    Who,
    WriteSession,
    services_of,
)
from server.web.problems import CONFLICT, NOT_FOUND
from tril.analysis.opinions import form_opinions
from tril.analysis.outcome import StatementAnswer, WantedAliens
from tril.analysis.wanted_aliens import Hits
from tril.games import game_of
from tril.ranking import normalise
from tril.recording import Recording as StoredRecording
from tril.store import answers, behaviours, borrowed, library, rankings, recordings, thing_names
from tril.store.models import RankingRow
from tril.teaching import varied_games
from tril.vocabulary.answers import Answer

router = APIRouter(prefix="/behaviours/{behaviour_id}/ranking", tags=["ranking"])
borrowed_router = APIRouter(prefix="/behaviours/{behaviour_id}/borrowed", tags=["ranking"])
slow_router = APIRouter(prefix="/behaviours/{behaviour_id}", tags=["ranking"])
"""Of what takes a tenth of a second or more: games are played, or much is computed."""

MAX_UNRANKED_OPINIONS = 60
MAX_NEXT_GAMES = 24
"""Unranked games, the newest first, among which the next one is chosen: each has to be watched."""

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
    session: WriteSession, identity: Who, behaviour_id: BehaviourId, update: RankingUpdate
) -> Ranking:
    """Save a ranking."""
    behaviours.get(session, behaviour_id)
    row = rankings.save(
        session, behaviour_id, update.base_revision, update.tiers, identity.player_id
    )
    return _view(session, row)


@router.post("/undo", responses=NOT_FOUND | _CONFLICT)
def undo_ranking(
    session: WriteSession, identity: Who, behaviour_id: BehaviourId, step: RankingStep
) -> Ranking:
    """Undo the last change."""
    behaviours.get(session, behaviour_id)
    return _view(
        session, rankings.undo(session, behaviour_id, step.base_revision, identity.player_id)
    )


@router.post("/redo", responses=NOT_FOUND | _CONFLICT)
def redo_ranking(
    session: WriteSession, identity: Who, behaviour_id: BehaviourId, step: RankingStep
) -> Ranking:
    """Redo the change that was undone last."""
    behaviours.get(session, behaviour_id)
    return _view(
        session, rankings.redo(session, behaviour_id, step.base_revision, identity.player_id)
    )


@router.post("/games", status_code=201, responses=NOT_FOUND | CONFLICT)
def add_games(
    session: WriteSession, identity: Who, behaviour_id: BehaviourId, games: BorrowedGames
) -> list[Recording]:
    """Borrow games for the ranking, unranked, and return them; those borrowed already stay so."""
    behaviours.get(session, behaviour_id)
    borrowed.borrow(session, behaviour_id, games.recording_ids)
    rows = recordings.by_ids(session, games.recording_ids)
    return RecordingViews(session, identity, behaviour_id).all(rows[key] for key in sorted(rows))


@slow_router.get("/ranking/opinion", responses=NOT_FOUND)
def get_ranking_opinion(request: Request, behaviour_id: BehaviourId) -> RankingOpinion:
    """Return where the other ranked games place each game, and which aliens they ask for."""
    with services_of(request).database.reading() as session:
        behaviours.get(session, behaviour_id)
        row = rankings.current(session, behaviour_id)
        ranking, revision = rankings.as_ranking(row), row.revision
        perfect = recordings.perfect_ids(session, behaviour_id)
        unranked = rankings.unranked(session, row)[:MAX_UNRANKED_OPINIONS]
        rows = recordings.by_ids(session, {*ranking.items, *unranked, *perfect})
        hits = {key: Hits.of(row.taken, row.n_frames) for key, row in rows.items()}
    opinions = form_opinions(ranking, hits, perfect)
    if opinions is None:
        return RankingOpinion(revision=revision, games=[], wanted=None)
    return RankingOpinion(
        revision=revision,
        games=[GameOpinion.of(opinion, recording_id=key) for key, opinion in opinions.of.items()],
        wanted=WantedAliens.of(opinions.labels.tolist(), opinions.in_order.tolist()),
    )


@slow_router.post("/ranking/understanding", responses=NOT_FOUND)
def understand_ranking(
    request: Request, behaviour_id: BehaviourId, shown: ShownOrder
) -> Understanding:
    """Return what an order is about in the terms of the game's things, saved or not.

    Asked first, Tril learns to see the game, and watches the games.
    """
    services = services_of(request)
    with services.database.reading() as session:
        behaviour = behaviours.get(session, behaviour_id)
        game = game_of(behaviours.as_behaviour(behaviour))
        order = rankings.without_unrankable(session, behaviour_id, normalise(shown.tiers))
        best = recordings.perfect_ids(session, behaviour_id)
        given_answers = answers.current(session, behaviour_id)
        unranked = rankings.unranked(session, rankings.current(session, behaviour_id))
        # As shown, saved or not.
        pool = [key for key in unranked if key not in order.items] if shown.with_next else []
        names = thing_names.current(session, game.name)

    def recordings_of(ids: Sequence[int]) -> dict[int, StoredRecording]:
        with services.database.reading() as session:
            rows = recordings.by_ids(session, ids)
            return {
                key: recordings.as_recording(row).with_hidden_areas_of(game)
                for key, row in rows.items()
            }

    understood = services.order_reader.read(
        game,
        order.tiers,
        best,
        [Answer(frozenset(answer.subjects), answer.meant) for answer in given_answers],
        recordings_of,
        pool[:MAX_NEXT_GAMES],
        names,
    )
    pictured = services.vocabularies.pictured(game)
    picture = picture_url(behaviour_id, game)
    return Understanding(
        state=understood.state,
        progress=round(understood.progress, 3),
        statements=[
            UnderstoodStatement(
                subjects=list(statement.told.subjects),
                sentence=statement.told.sentence,
                probability=round(statement.told.probability, 3),
                shown=statement.shown,
                contrast=statement.contrast,
                kinds=list(statement.told.kinds),
                detail=statement.told.detail,
                pictures=[
                    picture.format(kind) for kind in statement.told.kinds if kind in pictured
                ],
            )
            for statement in understood.statements
        ],
        is_sense=understood.is_sense,
        values={key: round(value, 3) for key, value in understood.values.items()},
        next_game=understood.next_game
        and NextGame.of(understood.next_game, recording_id=understood.next_game.game),
        contradiction=understood.contradiction and ContradictingGames.of(understood.contradiction),
        answers=given_answers,
    )


@router.get("/answers", responses=NOT_FOUND)
def list_statement_answers(
    session: ReadSession, behaviour_id: BehaviourId
) -> list[StatementAnswer]:
    """Return what people said of statements, the latest last."""
    behaviours.get(session, behaviour_id)
    return answers.current(session, behaviour_id)


@router.put("/answers", responses=NOT_FOUND)
def answer_statement(
    session: WriteSession, identity: Who, behaviour_id: BehaviourId, answer: StatementAnswerUpdate
) -> list[StatementAnswer]:
    """Answer a statement, or take an answer back; return the answers that count."""
    behaviours.get(session, behaviour_id)
    answers.give(
        session, behaviour_id, answer.subjects, answer.sentence, answer.meant, identity.player_id
    )
    return answers.current(session, behaviour_id)


@borrowed_router.get("", response_model=Library, responses=NOT_FOUND)
def list_borrowed_games(session: ReadSession, identity: Who, behaviour_id: BehaviourId) -> Response:
    """Return the games that a behaviour has borrowed, in brief, newest first."""
    behaviour = behaviours.get(session, behaviour_id)
    brief = library.borrowed(session, behaviour_id)
    return library_response(session, identity, behaviour, brief, borrowed=True)


@slow_router.post("/borrowed", status_code=201, responses=NOT_FOUND)
def add_varied_games(
    request: Request, identity: Who, behaviour_id: BehaviourId, wish: VariedGamesWish
) -> list[Recording]:
    """Add games of other behaviours and of varied play, unranked, and return them."""
    services = services_of(request)
    with services.database.reading() as session:
        game = behaviours.get(session, behaviour_id).game
    ids = varied_games.add_varied_games(
        services.database,
        behaviour_id,
        wish.count,
        lambda seed: services.replays.play_varied(game, seed).result(),
        np.random.default_rng(),
    )
    with services.database.reading() as session:
        rows = recordings.by_ids(session, ids)
        return RecordingViews(session, identity, behaviour_id).all(rows[key] for key in ids)


@borrowed_router.delete("/{recording_id}", status_code=204, responses=NOT_FOUND | CONFLICT)
def give_game_back(
    session: WriteSession, behaviour_id: BehaviourId, recording_id: RecordingId
) -> None:
    """Give a borrowed game back; a ranked one has to be taken off the board first."""
    behaviours.get(session, behaviour_id)
    borrowed.give_back(session, behaviour_id, recording_id)


async def on_conflict(request: Request, error: Exception) -> Response:
    """Answer a change of an old revision with both rankings."""
    assert isinstance(error, rankings.RankingConflict)
    body = await run_in_threadpool(_conflict, request, error)
    return JSONResponse(body, status_code=409)


def _conflict(request: Request, error: rankings.RankingConflict) -> dict[str, object]:
    with services_of(request).database.reading() as session:
        current = _view(session, rankings.current(session, error.behaviour_id))
    tiers = current.tiers if error.yours is None else [list(tier) for tier in error.yours]
    conflict = RankingConflict(detail=str(error), current=current, yours=tiers)
    return conflict.model_dump(mode="json")


def _view(session: Session, row: RankingRow) -> Ranking:
    return Ranking.of(
        row,
        n_pairs=rankings.as_ranking(row).n_pairs,
        can_undo=row.undo_to is not None,
        can_redo=row.redo_to is not None,
    )
