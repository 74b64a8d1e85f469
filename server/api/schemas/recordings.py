"""Recordings and their import."""

from __future__ import annotations

from datetime import datetime
from typing import Any, Literal

from pydantic import Field, StrictBool

from server.api.schemas.base import Column, Id, Row, Schema
from server.api.schemas.measures import MeasuredValue
from tril.analysis.summary import Policy
from tril.store.models import RecordingState, Source, Verification
from tril.store.training.evaluations import ActionSelection
from tril.text import Lines


class Hit(Schema):
    """An item that was taken, and the frame in which it was."""

    row: Row
    column: Column
    frame: int
    on_target: bool | None


class Latency(Schema):
    """The latency that the player of a game experienced (server.play.conditions).

    Milliseconds from a key's event to the drawing of the first frame executed with it;
    ``frames_dropped`` were executed but not drawn.
    """

    presses: int
    p50_ms: float | None
    p95_ms: float | None
    frames_dropped: int
    is_bad: bool


class BegunBy(Schema):
    """The policy that played the first ``frames`` frames of a person's game."""

    run_id: str
    policy: Policy
    action_selection: ActionSelection
    frames: int


class Branch(Schema):
    """A related recording, and the frame at which the two part."""

    recording_id: int
    number: int | None
    frame: int


class Recording(Schema):
    """``number`` names it among those of its behaviour, or of its run; None until it has ended.

    ``targets``, ``strays``, ``order_errors`` are None for behaviours without a target.

    ``frames_url`` and ``strip_url`` carry a version, so that they may be cached for ever.
    ``latency`` is None if it was not measured. ``slowest_percent`` is the slowest speed of play,
    100 being 60 Hz, and ``single_steps`` the number of frames executed one at a time; both are None
    if unknown. ``parent`` is the recording that this one continues; ``begun_by`` tells the policy
    that the player took the game over from.

    ``measured`` are the values of the behaviour's measures, in their order.

    ``borrowed`` tells a recording of another behaviour, called ``behaviour_name``, or of a
    training's policy, that the behaviour in question has borrowed for its ranking: ``targets``,
    ``strays``, ``order_errors``, ``measured`` and ``ranked`` are by the borrower's target, measures
    and ranking, and it is never ``perfect`` there.
    """

    id: int
    number: int | None
    behaviour_id: int
    behaviour_name: str
    borrowed: bool
    run_id: str | None
    source: Source
    player: str | None
    state: RecordingState
    verification: Verification
    verification_note: str
    game: str
    start: dict[str, int]
    evaluation_start: int | None
    n_frames: int
    n_steps: int
    end: str | None
    hits: list[Hit]
    hits_per_column: list[int]
    targets: int | None
    strays: int | None
    order_errors: int | None
    counters: dict[str, int]
    score: float | None
    measured: list[MeasuredValue]
    latency: Latency | None
    slowest_percent: int | None
    single_steps: int | None
    parent: Branch | None
    begun_by: BegunBy | None
    perfect: bool
    notes: str
    ranked: bool
    strip_url: str
    frames_url: str
    created_at: datetime
    deleted: bool


class MemoryCell(Schema):
    """The meaning of an address of the console's RAM."""

    address: int
    name: str


class RecordingCourse(Schema):
    """A recording frame by frame.

    ``actions[f]`` was executed in frame ``f + 1`` (docs/exchange-format.md names them).
    ``parent`` is the recording that this one continues, ``branches`` those that continue this one,
    oldest first. ``memory_url`` yields the RAM at the start and after every frame, 128 bytes each;
    ``memory_names`` names its known addresses.
    """

    actions: list[int]
    parent: Branch | None
    branches: list[Branch]
    conditions: dict[str, Any]
    memory_url: str
    memory_names: list[MemoryCell]


class RecordingUpdate(Schema):
    """Omitted fields stay."""

    perfect: StrictBool | None = None
    notes: Lines | None = Field(default=None, max_length=4000)


class ChosenRecordings(Schema):
    """Recordings of a behaviour: as many as a page can select."""

    recording_ids: list[Id] = Field(min_length=1, max_length=100_000)


class RecordingsChange(ChosenRecordings):
    """A change of several recordings of a behaviour, made to all or to none."""

    change: Literal["delete", "restore", "mark_perfect", "unmark_perfect"]


class Refusal(Schema):
    """``line`` counts from 1 in the uploaded file."""

    line: int
    reason: str


class ImportResult(Schema):
    """The outcome of an upload.

    ``imported`` are the new recordings, ``already_there`` those that the library had before.
    ``n_notices`` and ``n_refused`` count all messages; at most 20 of each kind are listed.
    """

    imported: list[int]
    already_there: list[int]
    notices: list[Refusal]
    refusals: list[Refusal]
    n_notices: int
    n_refused: int
