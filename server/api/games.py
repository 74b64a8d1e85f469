"""Games: begin one here, play it over its WebSocket (docs/protocol.md)."""

from __future__ import annotations

import numpy as np
from fastapi import APIRouter, Request
from sqlalchemy.orm import Session

from server.api.schemas import Game, GameFrom, GameNew
from server.dependencies import GameId, Reading, RecordingId, Writing, services_of
from server.play.conditions import PlayConditions
from server.web.problems import CONFLICT, NOT_FOUND
from tril.game.episode import Start, draw_start
from tril.game.space_invaders import MAX_FRAMES
from tril.store import behaviours, games, players, recordings
from tril.store.models import GameRow

router = APIRouter(prefix="/games", tags=["games"])


@router.post("", status_code=201, responses=NOT_FOUND)
def create_game(request: Request, session: Writing, new: GameNew) -> Game:
    """Begin a game; it waits for a player at its stream. 503 if too many games are open."""
    player_id = _player_with_a_place(request, session)
    behaviours.get(session, new.behaviour_id)
    # A person's games need no reproducible starts, only different ones.
    drawn = draw_start(np.random.default_rng())
    start = drawn if new.idle_frames is None else Start(new.idle_frames)
    return _shown(games.create(session, new.behaviour_id, start, player_id))


@router.post("/from/{recording_id}", status_code=201, responses=NOT_FOUND | CONFLICT)
def create_game_from(
    request: Request, session: Writing, recording_id: RecordingId, begin: GameFrom
) -> Game:
    """Begin a game that goes on from a frame of a recording, which stays as it is.

    503 if too many games are open.
    """
    player_id = _player_with_a_place(request, session)
    parent = recordings.get(session, recording_id)
    played = PlayConditions.from_conditions(parent.conditions)
    conditions = None if played is None else played.until(begin.frame).to_conditions()
    return _shown(games.create_from(session, parent, begin.frame, player_id, conditions))


@router.get("/{game_id}", responses=NOT_FOUND)
def get_game(session: Reading, game_id: GameId) -> Game:
    """Return a game as it was saved last."""
    return _shown(games.get(session, str(game_id)))


def _player_with_a_place(request: Request, session: Session) -> int:
    """Return who asks; raises TooManyGames if no further game may be opened."""
    player_id = players.owner(session).id
    services_of(request).limits.check(session, player_id)
    return player_id


def _shown(row: GameRow) -> Game:
    return Game(
        id=row.id,
        recording_id=row.recording_id,
        behaviour_id=row.recording.behaviour_id,
        frame=row.recording.n_frames,
        max_frames=MAX_FRAMES,
        stream_path=f"/api/games/{row.id}/stream",
    )
