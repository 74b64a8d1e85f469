"""A library in brief."""

from __future__ import annotations

from server.api.schemas.base import Schema
from tril.store.models import RecordingState, Source, Verification


class LibraryColumns(Schema):
    """Recordings in brief, newest first: each list has the values of one field.

    The fields are those of ``Recording``; ``parent_id`` and ``parent_frame`` are of its ``parent``,
    ``n_hits`` is the number of its ``hits``. ``behaviour_name`` is None for the behaviour's own.
    ``counters`` has a list for each of the game's, ``measured`` one of values for each of the
    behaviour's measures.
    """

    id: list[int]
    number: list[int | None]
    behaviour_name: list[str | None]
    source: list[Source]
    player: list[str | None]
    run_id: list[str | None]
    parent_id: list[int | None]
    parent_frame: list[int | None]
    state: list[RecordingState]
    verification: list[Verification]
    n_frames: list[int]
    n_steps: list[int]
    end: list[str | None]
    n_hits: list[int]
    targets: list[int | None]
    strays: list[int | None]
    order_errors: list[int | None]
    counters: dict[str, list[int]]
    score: list[float | None]
    measured: list[list[float | None]]
    perfect: list[bool]
    deleted: list[bool]


class Library(Schema):
    """A library in brief, a part of it, or what of it changed.

    ``cursor`` asks for what changes from here on. ``whole`` tells that ``recordings`` are all; else
    they are added, or replace those with the same ids, and ``removed`` are no longer in it.
    ``ranked`` are always all recordings in the ranking, best first.
    """

    cursor: int
    whole: bool
    removed: list[int]
    ranked: list[int]
    recordings: LibraryColumns
