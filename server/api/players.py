"""The person who plays."""

from __future__ import annotations

from fastapi import APIRouter

from server.api.schemas.players import Player, PlayerUpdate
from server.dependencies import Reading, Writing
from tril.store import players

router = APIRouter(prefix="/player", tags=["player"])


@router.get("")
def get_player(session: Reading) -> Player:
    """Return who plays here."""
    return Player.model_validate(players.owner(session))


@router.patch("")
def update_player(session: Writing, update: PlayerUpdate) -> Player:
    """Change the player's name."""
    row = players.owner(session)
    players.rename(session, row, update.name)
    return Player.model_validate(row)
