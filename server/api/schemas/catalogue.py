"""The games that can be taught."""

from __future__ import annotations

from datetime import datetime

from server.api.schemas.base import Cell, Schema
from server.api.schemas.behaviours import Settings
from server.api.schemas.measures import Measure


class Title(Schema):
    """A game in brief. ``last_played_at`` is null for those that nobody here has played.

    ``picture_url`` carries a version, so that it may be cached for ever.
    """

    name: str
    title: str
    picture_url: str
    n_behaviours: int
    last_played_at: datetime | None


class NamedRule(Schema):
    """When a loss ends a game."""

    name: str
    title: str


class NamedEnd(Schema):
    """A way in which a game ends. ``kind`` is death, failed, won or time."""

    name: str
    kind: str
    sentence: str


class Items(Schema):
    """The countable things of a game: cells of a grid, with row 0 at the bottom."""

    rows: int
    columns: int
    singular: str
    plural: str
    verb: str
    row_colours: list[str]


class Strip(Schema):
    """The sizes in pixels of the moments of a film strip, and of the reduced ones below them."""

    width: int
    height: int
    small_width: int
    small_height: int


class ReadyMade(Schema):
    """A behaviour that comes with a game, to be added as it is or changed."""

    slug: str
    name: str
    description: str
    target: list[Cell] | None
    ordered: bool
    settings: Settings
    measures: list[Measure]


class TaughtGame(Schema):
    """All that the page needs of a game.

    ``held`` are the buttons of each action, as bits in the order of ``buttons``. ``default_keys``
    are buttons by ``KeyboardEvent.code``. ``hidden`` are areas that learning does not see: left,
    top, right, bottom. ``options`` are values of the start by name, the first the default.
    ``things`` are those whose place is known, ``tallies`` what is counted when a game is measured,
    each by name with its title. What a game lacks is null, empty or false.
    """

    name: str
    title: str
    picture_url: str
    width: int
    height: int
    pixel_aspect: float
    strip: Strip
    frame_rate_hz: int
    frames_per_step: int
    max_steps: int
    longest_steps: int
    actions: list[str]
    buttons: list[str]
    held: list[int]
    default_keys: dict[str, str]
    waits: bool
    end_rules: list[NamedRule]
    ends: list[NamedEnd]
    options: dict[str, list[int]]
    hidden: list[tuple[int, int, int, int]]
    items: Items | None
    counters: dict[str, str]
    things: dict[str, str]
    tallies: dict[str, str]
    ready_made: list[ReadyMade]
    saves_states: bool
    has_memory: bool
    has_player: bool
    attribution: str
