"""Games: created here, played over their WebSocket (docs/protocol.md)."""

from __future__ import annotations

import numpy as np
from fastapi import APIRouter, Request

from server.api.schemas.games import Game, GameFrom, GameNew
from server.dependencies import GameId, ReadSession, RecordingId, Who, WriteSession, services_of
from server.play.conditions import PlayConditions
from server.web.permissions import refuse_foreign_behaviour
from server.web.problems import CONFLICT, NOT_FOUND
from tril.games import game_of
from tril.games.base import draw_start
from tril.store import behaviours, games, recordings
from tril.store.models import GameRow

router = APIRouter(prefix="/games", tags=["games"])


@router.post("", status_code=201, responses=NOT_FOUND | CONFLICT)
def create_game(request: Request, session: WriteSession, identity: Who, new: GameNew) -> Game:
    """Create a game, which begins when a player joins its stream. 503 if too many are open."""
    refuse_foreign_behaviour(identity, new.behaviour_id)
    services_of(request).limits.check(session, identity.player_id)
    behaviour = behaviours.as_behaviour(behaviours.get(session, new.behaviour_id))
    starts = game_of(behaviour).starts
    # Starts of people's games need not be reproducible.
    drawn = draw_start(starts, np.random.default_rng())
    start = drawn if new.start is None else starts.parse(new.start)
    return _view(games.create(session, new.behaviour_id, start, identity.player_id))


@router.post("/from/{recording_id}", status_code=201, responses=NOT_FOUND | CONFLICT)
def create_game_from(
    request: Request,
    session: WriteSession,
    identity: Who,
    recording_id: RecordingId,
    begin: GameFrom,
) -> Game:
    """Create a game that continues from a frame of a recording, which stays unchanged.

    503 if too many games are open.
    """
    services_of(request).limits.check(session, identity.player_id)
    parent = recordings.get(session, recording_id)
    played = PlayConditions.from_conditions(parent.conditions)
    conditions = None if played is None else played.until(begin.frame).to_conditions()
    return _view(games.create_from(session, parent, begin.frame, identity.player_id, conditions))


@router.get("/{game_id}", responses=NOT_FOUND)
def get_game(session: ReadSession, game_id: GameId) -> Game:
    """Return a game as last saved."""
    return _view(games.get(session, str(game_id)))


def _view(row: GameRow) -> Game:
    return Game.of(
        row,
        behaviour_id=row.recording.behaviour_id,
        frame=row.recording.n_frames,
        max_frames=recordings.as_recording(row.recording).game.clock.max_frames,
        stream_path=f"/api/games/{row.id}/stream",
    )
