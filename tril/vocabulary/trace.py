"""What is seen of a game step by step: memory, buttons, and the things on its screens."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from tril.games.base import Console, Game, Screen
from tril.play.episode import Episode
from tril.recording import Recording, exact_replay
from tril.vocabulary.blobs import BLOB_DTYPE, Background, Blobs, find_blobs
from tril.vocabulary.formations import Followed, Follower, Formation

MOST_SHIFT_PX = 6
"""Between the two last frames of a step, by which a thing seen in both may have moved."""

SAMPLED_SIZE = (105, 80)
"""Height and width of a screen on which is looked at what changes: half of a 2600's."""
BEGINNING_STEPS = 3
"""First steps of a game that show what it looks like at the beginning."""

LUMINANCE = (0.299, 0.587, 0.114)
"""Of red, green and blue (ITU-R BT.601)."""

LookAtStep = Callable[[list[Screen], bytes, bytes], None]
"""Called after each step: the screens of its last two frames, the memory, the step's actions."""


@dataclass(frozen=True, eq=False)
class Scene:
    """What the screens of a game have in common.

    Attributes:
        background: Most frequent colour of each pixel, uint8 (height, width).
        beginning: The same of the first steps of a game, see `brightest`.
        formation: Alike things that move together, if there are any.
    """

    background: Screen
    beginning: Screen
    formation: Formation | None = None


@dataclass(frozen=True)
class Trace:
    """A game, step by step.

    Attributes:
        memory: After each step, uint8 (n_steps, n_bytes); no bytes where the game has none to show.
        held: Buttons held in most frames of each step, as bits, int64 (n_steps,).
        blobs: Of all steps in order of time, BLOB_DTYPE.
        packed_changed: Of each step, which pixels of the sampled screen differ from the beginning
            of a game, in row-major order, packed into bits, uint8 (n_steps, n_bytes).
        n_cells: Number of pixels of the sampled screen.
        followed: Where the scene's formation is, if it has one.
    """

    memory: npt.NDArray[np.uint8]
    held: npt.NDArray[np.int64]
    blobs: Blobs
    packed_changed: npt.NDArray[np.uint8]
    n_cells: int
    followed: Followed | None = None

    @property
    def changed(self) -> npt.NDArray[np.bool_]:
        """Which pixels of the sampled screen differ from the beginning, (n_steps, n_cells)."""
        return np.unpackbits(self.packed_changed, axis=1, count=self.n_cells).view(np.bool_)

    @property
    def n_steps(self) -> int:
        """Number of steps."""
        return len(self.memory)


def strides_of(shape: tuple[int, ...]) -> tuple[int, int]:
    """Return every which row and column of a screen of a shape is sampled."""
    down, right = (-(-size // most) for size, most in zip(shape, SAMPLED_SIZE, strict=True))
    return down, right


def sampled(screen: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """Return a screen (height, width) with at most SAMPLED_SIZE rows and columns, some left out."""
    down, right = strides_of(screen.shape)
    return screen[::down, ::right]


def colours_of(screen: Screen, game: Game) -> Screen:
    """Return a colour number for each pixel, uint8 (height, width); 0 in areas that are hidden.

    RGB is rounded to eight levels of red and green and four of blue.
    """
    colours: Screen = np.array(screen)
    if game.screen.palette is None:
        red, green, blue = np.moveaxis(colours, 2, 0)
        colours = np.bitwise_or.reduce([red & 0xE0, green >> 3 & 0x1C, blue >> 6])
    for area in game.screen.hidden:
        colours[area.top : area.bottom, area.left : area.right] = 0
    return colours


def rgb_of(colours: npt.NDArray[np.uint8] | int, game: Game) -> npt.NDArray[np.float64]:
    """Return red, green and blue of colour numbers, float64 (..., 3), 0 to 255."""
    palette = game.screen.palette
    if palette is not None:
        rgb: npt.NDArray[np.float64] = palette[colours].astype(np.float64)
        return rgb
    number = np.asarray(colours)
    parts = [number & 0xE0, (number & 0x1C) << 3, (number & 3) << 6]
    return np.stack(parts, -1).astype(np.float64) + 16


def luminance_of(game: Game) -> npt.NDArray[np.float64]:
    """Return the luminance of each colour number, float64 (256,), 0 to 255."""
    luminance: npt.NDArray[np.float64] = rgb_of(np.arange(256, dtype=np.uint8), game) @ LUMINANCE
    return luminance


def brightest(screens: Sequence[Screen], luminance: npt.NDArray[np.float64]) -> Screen:
    """Return the brighter colour of each pixel of two frames, so that what flickers is seen.

    Observations are made so, too (maximum of the last two frames, Mnih et al. 2015).

    Args:
        screens: Colour numbers of one or two frames.
        luminance: See `luminance_of`.
    """
    first, last = screens[0], screens[-1]
    shown: Screen = np.where(luminance[first] > luminance[last], first, last)
    return shown


def look_at_steps(recording: Recording, console: Console, look: LookAtStep) -> None:
    """Replay a recording and look at every step; one that the end cuts short is left out.

    Raises:
        RecordingRefused: It was played on another version of the game, or the replay differs.
    """
    per_step = recording.game.clock.frames_per_step
    screens: list[Screen] = []

    def look_at_frame(episode: Episode) -> None:
        frame = episode.frame
        if not frame:
            return
        left = -frame % per_step
        if left <= 1:
            screens.append(colours_of(console.screen(), recording.game))
        if left == 0:
            look(screens, console.ram_bytes(), recording.actions[frame - per_step : frame])
            screens.clear()

    exact_replay(recording, console, look_at_frame)


def count_background(
    recording: Recording, console: Console, background: Background, beginning: Background
) -> None:
    """Count the colours of every third step of a recording, and those of its first steps."""
    luminance = luminance_of(recording.game)
    number = 0

    def look(screens: list[Screen], _memory: bytes, _actions: bytes) -> None:
        nonlocal number
        if number % 3 == 0:
            background.add(screens[-1])
        if number < BEGINNING_STEPS:
            beginning.add(brightest(screens, luminance))
        number += 1

    look_at_steps(recording, console, look)


def follow(recording: Recording, console: Console, formation: Formation) -> Followed:
    """Replay a recording and return where a formation is in it."""
    luminance = luminance_of(recording.game)
    follower = Follower(formation)
    look_at_steps(
        recording, console, lambda screens, *_: follower.look(brightest(screens, luminance))
    )
    return follower.followed


def trace(recording: Recording, console: Console, scene: Scene) -> Trace:
    """Replay a recording and return what is seen of it.

    Args:
        recording: The recording.
        console: A console of its game.
        scene: What the game's screens have in common, in colours as `colours_of` returns them.

    Raises:
        RecordingRefused: It was played on another version of the game, or the replay differs.
    """
    memory: list[npt.NDArray[np.uint8]] = []
    held: list[int] = []
    blobs: list[Blobs] = []
    changed: list[npt.NDArray[np.uint8]] = []
    beginning = sampled(scene.beginning)
    luminance = luminance_of(recording.game)
    controls = recording.game.controls
    follower = None if scene.formation is None else Follower(scene.formation)

    def look(screens: list[Screen], ram: bytes, actions: bytes) -> None:
        shown = brightest(screens, luminance)
        if follower is not None:
            follower.look(shown)
            # The items are told by the formation, and are no blobs.
            screens = [follower.without_items(screen, scene.background) for screen in screens]
        of_step = _blobs_of_step(screens, scene.background)
        of_step["step"] = len(memory)
        blobs.append(of_step)
        changed.append(np.packbits(sampled(shown) != beginning))
        memory.append(np.frombuffer(ram, np.uint8))
        action = int(np.bincount(np.frombuffer(actions, np.uint8)).argmax())
        held.append(controls.held[action])

    look_at_steps(recording, console, look)
    return Trace(
        np.array(memory, np.uint8).reshape(len(memory), len(console.ram_bytes())),
        np.array(held, np.int64),
        np.concatenate([np.empty(0, BLOB_DTYPE), *blobs]),
        np.array(changed, np.uint8).reshape(len(memory), -(-beginning.size // 8)),
        beginning.size,
        None if follower is None else follower.followed,
    )


def _blobs_of_step(screens: list[Screen], background: Screen) -> Blobs:
    """Return the last screen's blobs, and those that flicker: only the screen before shows them.

    A thing that moves far is not there twice: as many flicker as there are fewer of their colour.
    """
    last = find_blobs(screens[-1], background)
    if len(screens) == 1:
        return last
    before = find_blobs(screens[0], background)
    # (n_before, n_last): how far apart they are.
    distance = np.maximum(
        np.abs(before["x"][:, None] - last["x"]), np.abs(before["y"][:, None] - last["y"])
    )
    distance = np.where(before["colour"][:, None] == last["colour"], distance, np.inf)
    nearest = distance.min(axis=1, initial=np.inf)
    flickers = nearest >= MOST_SHIFT_PX
    for colour in np.unique(before["colour"][flickers]):
        own = np.flatnonzero(before["colour"] == colour)
        n_fewer = max(len(own) - int((last["colour"] == colour).sum()), 0)
        # What is nearest to one that is still there has moved.
        flickers[own[np.argsort(-nearest[own], kind="stable")[n_fewer:]]] = False
    return np.concatenate([before[flickers], last])
