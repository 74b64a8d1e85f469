"""Games."""

from __future__ import annotations

from pydantic import Field

from server.api.schemas.base import Id, Schema


class GameNew(Schema):
    """``idle_frames`` None draws a start for play."""

    behaviour_id: Id
    idle_frames: int | None = Field(default=None, strict=True, ge=0, le=127)


class GameFrom(Schema):
    """A game that goes on after this frame of a recording."""

    frame: int = Field(strict=True, ge=0, le=1200)


class Game(Schema):
    """``stream_path`` is the WebSocket's path (docs/protocol.md)."""

    id: str
    recording_id: int
    behaviour_id: int
    frame: int
    max_frames: int
    stream_path: str
