"""The player."""

from __future__ import annotations

from fastapi import APIRouter

from server.api.schemas.players import Player, PlayerUpdate
from server.dependencies import ReadSession, WriteSession
from tril.store import players

router = APIRouter(prefix="/player", tags=["player"])


@router.get("")
def get_player(session: ReadSession) -> Player:
    """Return the player."""
    return Player.model_validate(players.owner(session))


@router.patch("")
def update_player(session: WriteSession, update: PlayerUpdate) -> Player:
    """Change the player's name."""
    row = players.owner(session)
    players.rename(session, row, update.name)
    return Player.model_validate(row)
