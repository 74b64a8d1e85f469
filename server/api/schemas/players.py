"""Players."""

from __future__ import annotations

from pydantic import Field

from server.api.schemas.base import Schema
from tril.store.models import Role


class Player(Schema):
    """A player."""

    id: int
    name: str
    role: Role


class PlayerUpdate(Schema):
    """A player's new name."""

    name: str = Field(min_length=1, max_length=80)
