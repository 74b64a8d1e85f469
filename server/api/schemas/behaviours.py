"""Behaviours, their checklists and ghosts."""

from __future__ import annotations

from pydantic import Field, StrictBool

from server.api.schemas.base import MAX_CELLS, Cell, Schema
from server.api.schemas.measures import Measure, Measures, Pixel
from tril.games import DEFAULT_GAME
from tril.store.models import Source
from tril.text import Line, Lines


class Settings(Schema):
    """What a behaviour sets of its game; null leaves it as the game has it.

    ``hidden`` are areas of the screen that learning does not see: left, top, right, bottom in
    pixels, the last two outside. ``options`` are those of the game's starts.
    """

    hidden: list[tuple[Pixel, Pixel, Pixel, Pixel]] | None = Field(default=None, max_length=16)
    max_steps: int | None = Field(default=None, strict=True, ge=1, le=100_000)
    end_rule: str | None = Field(default=None, max_length=32)
    options: dict[str, int] = Field(default={}, max_length=8)


class Behaviour(Schema):
    """A behaviour. ``target`` is None if hits do not describe it."""

    id: int
    slug: str
    name: str
    description: str
    game: str
    settings: Settings
    measures: list[Measure]
    target: list[Cell] | None
    ordered: bool
    built_in: bool
    n_recordings: int
    n_ranked: int
    n_perfect: int
    n_runs: int
    has_example: bool


class BehaviourNew(Schema):
    """A behaviour to add. ``game`` is one of the catalogue's."""

    game: str = Field(default=DEFAULT_GAME, min_length=1, max_length=160)
    settings: Settings = Settings()
    measures: Measures = Field(default=[])

    name: Line = Field(min_length=1, max_length=120)
    description: Lines = Field(default="", max_length=2000)
    target: list[Cell] | None = Field(default=None, max_length=MAX_CELLS)
    ordered: StrictBool = False


class BehaviourUpdate(Schema):
    """Omitted fields stay. A target can't change once recordings or runs exist (409)."""

    name: Line | None = Field(default=None, min_length=1, max_length=120)
    description: Lines | None = Field(default=None, max_length=2000)
    target: list[Cell] | None = Field(default=None, max_length=MAX_CELLS)
    ordered: StrictBool | None = None
    settings: Settings | None = None
    measures: Measures | None = None


class PlannedDemonstration(Schema):
    """One of the demonstrations that exemplify a behaviour.

    ``recording_id`` and ``recording_number`` are of a recording that hits what it asks for and ends
    without the player's death; None while there is none.
    """

    number: int
    description: str
    recording_id: int | None
    recording_number: int | None


class Checklist(Schema):
    """``planned`` from best to worst; ``note`` says why it is empty."""

    planned: list[PlannedDemonstration]
    note: str


class Ghost(Schema):
    """The cannon's rectangle in a recording, in pixels of the screen.

    ``lefts`` are its left edges at the start and after every frame.
    """

    recording_id: int
    number: int | None
    source: Source
    lefts: list[int]
    top: int
    width: int
    height: int
