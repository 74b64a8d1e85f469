"""What a game is: the interface between a game and everything that plays, records and learns it.

A game lies below everything else: it imports no torch, no SQL and no web.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from enum import StrEnum
from functools import cached_property, lru_cache
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from tril.errors import Invalid
from tril.games.behaviours import Behaviour
from tril.games.behaviours import Cell as Cell
from tril.games.settings import (
    MAX_HIDDEN,
    MAX_STEPS,
    MIN_STEPS,
    UNSET,
    GameSettings,
)
from tril.games.settings import Rectangle as Rectangle
from tril.games.things import Tally, Thing

Screen = npt.NDArray[np.uint8]
"""A screen: uint8 (height, width) of palette values, or (height, width, 3) RGB."""

JsonObject = dict[str, Any]

MAX_EVALUATION_STARTS = 32
"""Most evaluation starts of any game; their start numbers count from 0."""

MAX_FRAMES = 100_000
"""Most frames of an episode of any game."""


class UnknownStart(Invalid):
    """A start or start number that does not exist or is not supported."""


class EndKind(StrEnum):
    """The meaning of an end outside of its game."""

    DEATH = "death"
    """The player died."""
    FAILED = "failed"
    """The game was lost in another way."""
    WON = "won"
    """Nothing is left to do."""
    TIME = "time"
    """The time limit; learning bootstraps the value of the last observation."""


@dataclass(frozen=True)
class End:
    """A way in which an episode ends.

    Attributes:
        name: Name in recordings and files, e.g. "landed".
        kind: Meaning outside of the game.
        sentence: Description for people, e.g. "the ball was missed".
    """

    name: str
    kind: EndKind
    sentence: str


@dataclass(frozen=True)
class EndRule:
    """When the loss of a life or of the game ends an episode.

    Attributes:
        name: Name in recordings and files, e.g. "life".
        title: Its name for people, e.g. "at the first life lost".
    """

    name: str
    title: str


@dataclass(frozen=True)
class Clock:
    """The time of a game.

    Attributes:
        frame_rate_hz: Frames per second when a person plays.
        frames_per_step: Frames that an agent repeats an action for.
        max_steps: Steps after which an episode ends.
    """

    frame_rate_hz: int = 60
    frames_per_step: int = 4
    max_steps: int = 300

    @property
    def max_frames(self) -> int:
        """Frames after which an episode ends."""
        return self.max_steps * self.frames_per_step

    def n_steps(self, n_frames: int) -> int:
        """Return the number of steps in so many frames, with one cut short by the end."""
        return -(-n_frames // self.frames_per_step)


@dataclass(frozen=True)
class Controls:
    """The actions of a game and the buttons that a person holds for them.

    Attributes:
        actions: Names of the actions; the index is the byte in a recording and a policy's output.
        buttons: Names of the buttons; bit n of the play protocol is the n-th.
        held: The buttons held for each action, as bits; the neutral action has none.
        default_keys: Buttons by `KeyboardEvent.code`, the physical key.
        waits: Whether the game stands still until a button is held, as it has no neutral action.
    """

    actions: tuple[str, ...]
    buttons: tuple[str, ...]
    held: tuple[int, ...]
    default_keys: Mapping[str, str]
    waits: bool = False

    @property
    def n_actions(self) -> int:
        """Number of actions."""
        return len(self.actions)

    @property
    def all_buttons(self) -> int:
        """All buttons, as bits."""
        return (1 << len(self.buttons)) - 1

    @cached_property
    def noop(self) -> int:
        """The neutral action; the first one where there is none."""
        return self.held.index(0) if 0 in self.held else 0

    @cached_property
    def _opposites(self) -> tuple[int, ...]:
        pairs = (("left", "right"), ("up", "down"))
        return tuple(
            1 << self.buttons.index(button) | 1 << self.buttons.index(opposite)
            for button, opposite in pairs
            if button in self.buttons and opposite in self.buttons
        )

    @cached_property
    def _action_of(self) -> dict[int, int]:
        return {held: action for action, held in reversed(list(enumerate(self.held)))}

    def action_for(self, held: int) -> int:
        """Return the action of the held buttons, given as bits.

        Opposite directions cancel out, as on a joystick. Where no action has all of the buttons,
        the action with most of them is returned, the first of several.
        """
        held &= self.all_buttons
        for pair in self._opposites:
            if held & pair == pair:
                held &= ~pair
        action = self._action_of.get(held)
        if action is None:
            inside = [bits & ~held == 0 for bits in self.held]
            sizes = [
                bits.bit_count() if fits else -1
                for bits, fits in zip(self.held, inside, strict=True)
            ]
            action = self._action_of[held] = (
                sizes.index(max(sizes)) if max(sizes) >= 0 else self.noop
            )
        return action


@dataclass(frozen=True, order=True)
class Start(ABC):
    """How a game begins. Each family of games has its own values; all are integers."""

    @property
    @abstractmethod
    def key(self) -> tuple[int, ...]:
        """The values, which identify the start and seed draws of its own."""

    @abstractmethod
    def to_json(self) -> JsonObject:
        """Return the values by name; `Starts.parse` reads them."""


@dataclass(frozen=True)
class Opening:
    """A start and the steps that are played before the player's first.

    They are part of the episode: they count towards its length, and a recording holds them.

    Attributes:
        start: Start of the game.
        actions: The action of each step.
    """

    start: Start
    actions: tuple[int, ...]


def start_of(beginning: Start | Opening) -> Start:
    """Return the start of a game that begins with an opening or without."""
    return beginning.start if isinstance(beginning, Opening) else beginning


class Starts(Protocol):
    """The starts of a game, some of them held out for evaluation."""

    @property
    def n_evaluation(self) -> int:
        """Number of evaluation starts; their start numbers count from 0."""

    @property
    def training(self) -> Sequence[Start]:
        """The starts for play, demonstrations and training; none is an evaluation start."""

    def parse(self, data: JsonObject) -> Start:
        """Read what `Start.to_json` returned.

        Raises:
            UnknownStart: A value is missing, unknown or out of its range.
        """

    @property
    def options(self) -> Mapping[str, Sequence[int]]:
        """What a behaviour can choose of its starts, by name; the first value is the default."""

    def with_options(self, options: Mapping[str, int]) -> Starts:
        """Return the starts with other options.

        Raises:
            UnknownStart: There is no such option or value.
        """

    def evaluation(self, number: int) -> Start:
        """Return the evaluation start with this start number.

        Raises:
            UnknownStart: There is none.
        """

    def evaluation_number(self, start: Start) -> int | None:
        """Return the start number of an evaluation start, None for others."""

    def evaluation_opening(self, number: int) -> Opening:
        """Return the opening of an evaluation start, fixed like the start itself.

        Raises:
            UnknownStart: There is no such start number.
        """

    def draw_opening(self, start: Start, rng: np.random.Generator) -> Opening:
        """Draw an opening, which makes games from one start differ."""


def draw_start(starts: Starts, rng: np.random.Generator) -> Start:
    """Draw a start for play, demonstrations or training, never an evaluation start."""
    return starts.training[int(rng.integers(len(starts.training)))]


def spread_starts(starts: Sequence[Start], count: int) -> list[Start]:
    """Return starts spread evenly over these, at most all of them."""
    places = np.linspace(0, len(starts) - 1, min(count, len(starts)))
    return [starts[round(place)] for place in places]


def evaluation_beginning(starts: Starts, number: int, openings: bool) -> Start | Opening:
    """Return the beginning of an evaluation start's game, with its opening or without.

    Raises:
        UnknownStart: There is no such start number.
    """
    return starts.evaluation_opening(number) if openings else starts.evaluation(number)


class ConsoleState(Protocol):
    """A saved console, which can be restored into any console of the game in any process."""

    def to_bytes(self) -> bytes:
        """Return the state as bytes; `Console.state_from_bytes` reads them."""


StartCache = dict[Start, ConsoleState]
"""Console states at starts, to be shared by the consoles of a process."""


class Console(Protocol):
    """What runs a game, frame by frame. Deterministic in start and actions."""

    game: Game
    score: float
    """Rewards of the game itself since its start; never seen by learning."""

    def start(self, start: Start) -> None:
        """Begin a game, past what precedes it."""

    def act(self, action: int) -> None:
        """Run one frame with this action."""

    @property
    def over(self) -> bool:
        """Whether the game itself has ended."""

    @property
    def lives(self) -> int:
        """Lives left; 0 in games without."""

    def ram_bytes(self) -> bytes:
        """Return the memory; empty where the game has none to show."""

    def state_hash(self) -> str:
        """Return a digest of the memory, or of the screen: 16 hexadecimal digits of BLAKE2b."""

    def screen(self, out: Screen | None = None) -> Screen:
        """Return the screen, in out if given."""

    def save(self) -> ConsoleState:
        """Return the state of the console.

        Raises:
            Invalid: The game does not save states.
        """

    def restore(self, state: ConsoleState) -> None:
        """Restore a saved state; equal actions then give equal frames."""

    def state_from_bytes(self, data: bytes) -> ConsoleState:
        """Read a saved state.

        Raises:
            ValueError: The bytes are of another format version.
        """

    def close(self) -> None:
        """Free what the console holds."""


@dataclass(frozen=True)
class Taken:
    """An item that was taken: a brick broken, a dot eaten.

    Attributes:
        row: Row in the game's grid of items, from 0 at the bottom.
        column: Column, from 0 at the left.
        frame: Frames of the episode executed by then, at least 1.
    """

    row: int
    column: int
    frame: int

    @property
    def cell(self) -> Cell:
        """The item: its cell of the grid."""
        return self.row, self.column


@dataclass(frozen=True)
class ItemGrid:
    """The countable things of a game, as cells of a grid.

    They serve measures and pictures, not learning.

    Attributes:
        rows: Number of rows; row 0 is at the bottom.
        columns: Number of columns; column 0 is at the left.
        singular: One of them, e.g. "brick".
        plural: Several, e.g. "bricks".
        verb: What taking one is called, in the infinitive, e.g. "break".
        row_colours: Colour of each row from the bottom, e.g. "#869e30"; none for the page's own.
    """

    rows: int
    columns: int
    singular: str
    plural: str
    verb: str
    row_colours: tuple[str, ...] = ()

    def __contains__(self, cell: Cell) -> bool:
        """Return whether there is such a cell."""
        return 0 <= cell[0] < self.rows and 0 <= cell[1] < self.columns


def cell_name(cell: Cell) -> str:
    """Return the name of a cell for people, with rows and columns from 1."""
    return f"row {cell[0] + 1}, column {cell[1] + 1}"


class Readout(Protocol):
    """Follows one episode: what is taken, what is counted, and when it ends.

    Attributes:
        taken: Items taken so far, in order of time.
        counters: Counts since the start, by name.
    """

    taken: list[Taken]
    counters: dict[str, int]

    def update(self, console: Console, frame: int) -> str | None:
        """Read a frame that was executed; return the name of the end that it brought, if any."""

    def marks(self, console: Console) -> bytes:
        """Return the overlay data of the current frame; `Overlay.marks_bytes` long."""

    def save(self) -> JsonObject:
        """Return the state, besides items and counters."""

    def restore(self, state: JsonObject) -> None:
        """Restore a saved state."""


@dataclass(frozen=True, eq=False)
class ScreenSpec:
    """The screen of a game.

    Attributes:
        height: Height in pixels.
        width: Width in pixels.
        palette: Colours by value, uint8 (256, 3) RGB; None where screens are RGB themselves.
        grayscale: Grays by palette value, uint8 (256,); None where screens are RGB themselves.
        hidden: Areas that learning does not see: the score, the lives.
        background: Gray that occlusion paints with, 0 to 255.
        pixel_aspect: Width of a pixel by its height, as shown.
    """

    height: int
    width: int
    palette: npt.NDArray[np.uint8] | None
    grayscale: npt.NDArray[np.uint8] | None
    hidden: tuple[Rectangle, ...] = ()
    background: int = 0
    pixel_aspect: float = 1.0

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of a Screen."""
        return (
            (self.height, self.width) if self.palette is not None else (self.height, self.width, 3)
        )


@dataclass(frozen=True)
class Track:
    """The place of a thing through a recording, in pixels of the screen.

    Attributes:
        lefts: Left edge at the start and after every frame.
        top: Top edge.
        width: Width.
        height: Height.
    """

    lefts: tuple[int, ...]
    top: int
    width: int
    height: int


@dataclass(frozen=True)
class Overlay:
    """What the page may draw over a screen.

    Attributes:
        painter: Name of the page's painter.
        geometry: Constants of the overlay, in pixels.
        marks_bytes: Bytes of `Readout.marks` for each frame.
    """

    painter: str
    geometry: Mapping[str, int]
    marks_bytes: int


@dataclass(frozen=True, eq=False)
class Game:
    """A game that can be taught.

    Attributes:
        name: Name in rows, files and URLs, e.g. "breakout" or "gym:CartPole-v1".
        title: Name for people.
        version: Version that replays depend on: the MD5 of the ROM, or the package's version.
        clock: Frame rate and step length.
        controls: Actions and buttons.
        starts: Starts of episodes.
        screen: Screen of the game.
        ends: The ways in which its episodes end.
        end_rules: When a loss ends an episode; the first is the default.
        new_console: Makes a console; `make_console` calls it.
        new_readout: Makes the readout of an episode at its start, for an end rule.
        saves_states: Whether consoles save states: for rewinding, and for starts inside
            demonstrations.
        has_memory: Whether consoles have a memory to show.
        items: The countable things in it, if any.
        counters: Names of what is counted, with what it is, e.g. {"shots": "missiles fired"}.
        things: Things whose place its memory tells, by name.
        tallies: Counts read from bytes of memory, by name.
        pieces: What the pieces of its still picture are called that games clear, e.g. "dots";
            empty if they have no name.
        formation: What the alike things are called that move together, e.g. "ships"; empty if
            they have no name.
        overlay: What the page may draw over its screens, if anything.
        memory_names: Names of memory addresses.
        ghost: Reads the player's track off a recording's memory and start; None if it can't be.
        pretrained: Whether networks that ship with Tril have learned to read its screens.
        behaviours: Ready-made behaviours, offered where a person adds one.
        attribution: Licence and origin, where it has to be told.
        settings: What a behaviour sets of it; is in force in the other attributes.
    """

    name: str
    title: str
    version: str
    clock: Clock
    controls: Controls
    starts: Starts
    screen: ScreenSpec
    ends: tuple[End, ...]
    end_rules: tuple[EndRule, ...]
    new_console: Callable[[Game, StartCache], Console]
    new_readout: Callable[[Console, str], Readout]
    saves_states: bool = True
    has_memory: bool = True
    items: ItemGrid | None = None
    counters: Mapping[str, str] = field(default_factory=dict)
    things: Mapping[str, Thing] = field(default_factory=dict)
    tallies: Mapping[str, Tally] = field(default_factory=dict)
    pieces: str = ""
    formation: str = ""
    overlay: Overlay | None = None
    memory_names: Mapping[int, str] = field(default_factory=dict)
    ghost: Callable[[bytes, Start], Track] | None = None
    pretrained: bool = False
    behaviours: tuple[Behaviour, ...] = ()
    attribution: str = ""
    settings: GameSettings = UNSET

    def make_console(self, start_cache: StartCache | None = None) -> Console:
        """Make a console of the game.

        Args:
            start_cache: Starts reached before, shared with other consoles of this process.
        """
        return self.new_console(self, {} if start_cache is None else start_cache)

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle by name, as consoles and readouts are made by functions of the game's module."""
        return _unpickled, (self.name, self.settings)

    def with_settings(self, settings: GameSettings) -> Game:
        """Return the game as a behaviour sets it.

        Raises:
            Invalid: The game has no such end rule or option, or cannot be as long.
        """
        if settings == self.settings:
            return self
        plain = self if self.settings == UNSET else _named(self.name)
        return plain if settings == UNSET else _with_settings(plain, settings)

    def end(self, name: str) -> End:
        """Return the end of this name.

        Raises:
            Invalid: There is none.
        """
        for end in self.ends:
            if end.name == name:
                return end
        names = ", ".join(end.name for end in self.ends)
        raise Invalid(f"{self.title} has no end {name!r}; it has {names}.")

    def is_death(self, end: str | None) -> bool:
        """Return whether an end, by its name, is the player's death."""
        return end is not None and self.end(end).kind is EndKind.DEATH

    @property
    def time_end(self) -> str:
        """Name of the end that the time limit brings."""
        return next(end.name for end in self.ends if end.kind is EndKind.TIME)

    @property
    def end_rule(self) -> str:
        """Name of the default end rule."""
        return self.end_rules[0].name

    def known_end_rule(self, name: str) -> str:
        """Return the name of an end rule if the game has it, else that of the default."""
        return name if any(rule.name == name for rule in self.end_rules) else self.end_rule

    def check_target(self, behaviour: Behaviour) -> None:
        """Check that a behaviour's targets are items of the game.

        Raises:
            Invalid: They are not.
        """
        if behaviour.target is None:
            return
        items = self.items
        if items is None:
            raise Invalid(f"{self.title} has nothing that can be counted as a target.")
        for row, column in behaviour.target:
            if (row, column) not in items:
                raise Invalid(
                    f"Expected target {items.plural} in rows 0..{items.rows - 1} and columns"
                    f" 0..{items.columns - 1}, got ({row}, {column})."
                )

    def check_end_rule(self, name: str) -> str:
        """Return the name of an end rule.

        Raises:
            Invalid: There is none of this name.
        """
        names = [rule.name for rule in self.end_rules]
        if name not in names:
            raise Invalid(f"{self.title} has no end rule {name!r}; it has {', '.join(names)}.")
        return name


@lru_cache(maxsize=256)
def _with_settings(plain: Game, settings: GameSettings) -> Game:
    screen, clock, end_rules = plain.screen, plain.clock, plain.end_rules
    if settings.hidden is not None:
        if len(settings.hidden) > MAX_HIDDEN:
            raise Invalid(f"At most {MAX_HIDDEN} areas can be hidden, got {len(settings.hidden)}.")
        for area in settings.hidden:
            if area.right > screen.width or area.bottom > screen.height:
                raise Invalid(
                    f"Expected areas within the screen of {screen.width} x {screen.height} pixels,"
                    f" got one to {area.right}, {area.bottom}."
                )
        screen = replace(screen, hidden=settings.hidden)
    if settings.max_steps is not None:
        if not MIN_STEPS <= settings.max_steps <= MAX_STEPS:
            raise Invalid(
                f"Expected games of {MIN_STEPS} to {MAX_STEPS} steps, got {settings.max_steps}."
            )
        clock = replace(clock, max_steps=settings.max_steps)
    if settings.end_rule is not None:
        name = plain.check_end_rule(settings.end_rule)
        end_rules = tuple(sorted(end_rules, key=lambda rule: rule.name != name))
    return replace(
        plain,
        screen=screen,
        clock=clock,
        end_rules=end_rules,
        starts=plain.starts.with_options(dict(settings.options)),
        settings=settings,
    )


def _named(name: str) -> Game:
    from tril.games import game_named

    return game_named(name)


def _unpickled(name: str, settings: GameSettings) -> Game:
    return _named(name).with_settings(settings)


class GameFamily(Protocol):
    """Games that are made from their names, without a module each."""

    def titles(self) -> Mapping[str, str]:
        """Return the titles of those that are installed by their names, without making them."""

    def game(self, name: str) -> Game | None:
        """Return the game of a name, None if it is not one of this family.

        Raises:
            Invalid: It is one, but cannot be taught; says why.
        """
