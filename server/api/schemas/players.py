"""Players."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from server.api.schemas.base import Schema


class Player(Schema):
    """A player."""

    id: int
    name: str
    role: Literal["owner", "researcher", "participant"]


class PlayerUpdate(Schema):
    """A player's new name."""

    name: str = Field(min_length=1, max_length=80)
