"""Games."""

from __future__ import annotations

from pydantic import Field

from server.api.schemas.base import Id, Schema


class GameNew(Schema):
    """A game to create. Without ``idle_frames`` its start is drawn at random."""

    behaviour_id: Id
    idle_frames: int | None = Field(default=None, strict=True, ge=0, le=127)


class GameFrom(Schema):
    """The frame of a recording after which a game continues."""

    frame: int = Field(strict=True, ge=0, le=1200)


class Game(Schema):
    """A game. ``stream_path`` is its WebSocket's path (docs/protocol.md)."""

    id: str
    recording_id: int
    behaviour_id: int
    frame: int
    max_frames: int
    stream_path: str
