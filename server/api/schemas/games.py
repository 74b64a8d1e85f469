"""Games."""

from __future__ import annotations

from pydantic import Field

from server.api.schemas.base import Id, Schema
from tril.games.base import MAX_FRAMES


class GameNew(Schema):
    """A game to create. Without ``start`` its start is drawn at random."""

    behaviour_id: Id
    start: dict[str, int] | None = Field(default=None, max_length=8)


class GameFrom(Schema):
    """The frame of a recording after which a game continues."""

    frame: int = Field(strict=True, ge=0, le=MAX_FRAMES)


class Game(Schema):
    """A game. ``stream_path`` is its WebSocket's path (docs/protocol.md)."""

    id: str
    recording_id: int
    behaviour_id: int
    frame: int
    max_frames: int
    stream_path: str
