"""Recordings and their import."""

from __future__ import annotations

from datetime import datetime
from typing import Any, Literal

from pydantic import Field, StrictBool

from server.api.schemas.base import Column, Id, Row, Schema


class Hit(Schema):
    """An alien that was shot, after how many frames."""

    row: Row
    column: Column
    frame: int
    on_target: bool | None


class Latency(Schema):
    """How late a game was seen by who played it (server.play.conditions).

    Milliseconds from the event of a key to the drawing of the first frame executed with it;
    ``frames_dropped`` were executed and not drawn.
    """

    presses: int
    p50_ms: float | None
    p95_ms: float | None
    frames_dropped: int
    is_bad: bool


class Branch(Schema):
    """A recording and the frame at which the other one leaves it."""

    recording_id: int
    frame: int


class Recording(Schema):
    """``targets``, ``strays``, ``order_errors`` are None for behaviours without a target.

    ``frames_url`` and ``thumbnail_url`` carry a version so that they may be cached for ever.
    ``latency`` is None where it was not measured. ``slowest_percent`` is the slowest speed that it
    was played at, 100 being 60 Hz, and ``single_steps`` how many frames were executed one at a
    time; both are None where that is not known. ``parent`` is the recording that this one goes on
    from.
    """

    id: int
    behaviour_id: int
    run_id: str | None
    source: Literal["person", "scripted", "policy"]
    player: str | None
    state: Literal["playing", "unfinished", "finished", "kept"]
    verification: Literal["pending", "verified", "failed"]
    verification_note: str
    idle_frames: int
    evaluation_start: int | None
    n_frames: int
    n_steps: int
    end: str | None
    hits: list[Hit]
    hits_per_column: list[int]
    targets: int | None
    strays: int | None
    order_errors: int | None
    shots: int
    latency: Latency | None
    slowest_percent: int | None
    single_steps: int | None
    parent: Branch | None
    perfect: bool
    notes: str
    ranked: bool
    thumbnail_url: str
    frames_url: str
    created_at: datetime
    deleted: bool


class MemoryCell(Schema):
    """What an address of the console's RAM holds."""

    address: int
    name: str


class RecordingCourse(Schema):
    """A recording frame by frame.

    ``actions[f]`` was executed in frame ``f + 1`` (docs/exchange-format.md names them).
    ``parent`` is the recording that this one goes on from, ``branches`` those that go on from it,
    oldest first. At ``memory_url`` is the RAM at the start and after every frame, 128 bytes each;
    ``memory_names`` names what is known of it.
    """

    actions: list[int]
    parent: Branch | None
    branches: list[Branch]
    conditions: dict[str, Any]
    memory_url: str
    memory_names: list[MemoryCell]


class RecordingUpdate(Schema):
    """Fields left out stay."""

    perfect: StrictBool | None = None
    notes: str | None = Field(default=None, max_length=4000)


class RecordingsChange(Schema):
    """Something to do to several recordings of a behaviour, to all or to none."""

    recording_ids: list[Id] = Field(min_length=1, max_length=500)
    change: Literal["delete", "restore", "mark_perfect", "unmark_perfect"]


class Refusal(Schema):
    """``line`` counts from 1 in the uploaded file."""

    line: int
    reason: str


class ImportResult(Schema):
    """What became of an uploaded file; ``imported`` are the new recordings."""

    imported: list[int]
    notices: list[Refusal]
    refusals: list[Refusal]
