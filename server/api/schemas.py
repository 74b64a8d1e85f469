"""What goes over HTTP. The frontend's types are generated from these."""

from __future__ import annotations

from datetime import datetime
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, StrictBool

Row = Annotated[int, Field(strict=True, ge=0, le=5)]
Column = Annotated[int, Field(strict=True, ge=0, le=5)]
Cell = tuple[Row, Column]
"""(row from the bottom, column from the left), from 0."""

Id = Annotated[int, Field(strict=True, ge=1, le=2**31 - 1)]
Tiers = Annotated[
    list[Annotated[list[Id], Field(min_length=1, max_length=500)]], Field(max_length=500)
]


class Schema(BaseModel):
    """Base: unknown fields are refused, rows can be read by attribute."""

    model_config = ConfigDict(extra="forbid", from_attributes=True)


class Health(Schema):
    """The server answers; ``failing`` names the background tasks whose last run failed, if any."""

    status: Literal["ok", "degraded"]
    failing: list[str] | None = None


class Player(Schema):
    """Who plays."""

    id: int
    name: str
    role: Literal["owner", "researcher", "participant"]


class PlayerUpdate(Schema):
    """A player's new name."""

    name: str = Field(min_length=1, max_length=80)


class ProcessStatus(Schema):
    """``alive`` is false when nothing was heard for 15 s."""

    name: str
    kind: Literal["server", "worker", "inference"]
    alive: bool
    details: dict[str, Any]


class Storage(Schema):
    """What the data folder holds; the cache never takes more than its limit."""

    databases_bytes: int
    artifacts_bytes: int
    cache_bytes: int
    cache_limit_bytes: int
    other_bytes: int


class System(Schema):
    """Whether Tril is well. ``data_bytes`` is what the parts of ``storage`` take together."""

    version: str
    processes: list[ProcessStatus]
    disk_free_bytes: int
    data_bytes: int
    storage: Storage


class Behaviour(Schema):
    """What is being taught. ``target`` is None where hits do not describe it."""

    id: int
    slug: str
    name: str
    description: str
    target: list[Cell] | None
    ordered: bool
    built_in: bool
    n_recordings: int
    n_ranked: int
    n_perfect: int
    n_runs: int
    has_example: bool


class BehaviourNew(Schema):
    """A behaviour of one's own."""

    name: str = Field(min_length=1, max_length=120)
    description: str = Field(default="", max_length=2000)
    target: list[Cell] | None = Field(default=None, max_length=36)
    ordered: StrictBool = False


class BehaviourUpdate(Schema):
    """Fields left out stay. A target can't change once runs exist (409)."""

    name: str | None = Field(default=None, min_length=1, max_length=120)
    description: str | None = Field(default=None, max_length=2000)
    target: list[Cell] | None = Field(default=None, max_length=36)
    ordered: StrictBool | None = None


class PlannedDemonstration(Schema):
    """One of the demonstrations that exemplify a behaviour.

    ``recording_id`` is a recording that hit what it asks for and was survived to its end; None
    while it is missing.
    """

    number: int
    description: str
    recording_id: int | None


class Checklist(Schema):
    """``planned`` best first; ``note`` says why there are none."""

    planned: list[PlannedDemonstration]
    note: str


class Ghost(Schema):
    """Where the cannon of a recording stood on the screen, in pixels.

    ``lefts`` are its left edges: at the start, then after every frame.
    """

    recording_id: int
    source: Literal["person", "scripted", "policy"]
    lefts: list[int]
    top: int
    width: int
    height: int


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


class Ranking(Schema):
    """``tiers`` best first; ``unranked`` the kept, verified recordings in no tier, newest first."""

    behaviour_id: int
    revision: int
    tiers: list[list[int]]
    unranked: list[int]
    n_pairs: int
    can_undo: bool
    can_redo: bool


class RankingUpdate(Schema):
    """``base_revision`` is the revision that was changed; an old one gives 409 RankingConflict."""

    base_revision: int = Field(strict=True, ge=0, le=2**31 - 1)
    tiers: Tiers


class RankingStep(Schema):
    """Undo or redo from this revision."""

    base_revision: int = Field(strict=True, ge=0, le=2**31 - 1)


class RankingConflict(Schema):
    """Somebody saved first: ``current`` is what stands, ``yours`` what was sent."""

    detail: str
    current: Ranking
    yours: list[list[int]]


class RankingRevision(Schema):
    """What was done to a ranking."""

    revision: int
    tiers: list[list[int]]
    change: Literal["edit", "undo", "redo", "import", "deletion", "example"]
    player: str | None
    created_at: datetime


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
