"""Film strips: eight moments of a recording that differ, as one picture."""

from __future__ import annotations

import io
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from PIL import Image

from tril.games.base import Console, Screen, ScreenSpec
from tril.play.episode import Episode
from tril.recording import Recording, replay

N_MOMENTS = 8
COLUMNS = 2
"""Columns of moments in a strip."""
SMALL_COLUMNS = 4
"""Columns of reduced moments, below the others."""

_N_CANDIDATES = 64
_WIDEST = 320
"""Width in pixels from which moments are reduced, too."""
_SMALL_WIDEST = 80
_LOOK = (16, 21)
"""Width and height of the thumbnails that moments are compared by."""
_WEIGHT_OF_TIME = 0.5
"""A whole game apart counts as half of the greatest difference in looks."""

Picture = npt.NDArray[np.uint8]


@dataclass(frozen=True)
class StripFormat:
    """Sizes of a game's film strips in pixels.

    The moments are in order of time, row by row, in two columns; below them are the same, reduced,
    in four columns.

    Attributes:
        width: Width of a moment.
        height: Height of a moment.
        small_width: Width of a reduced moment.
        small_height: Height of a reduced moment.
    """

    width: int
    height: int
    small_width: int
    small_height: int

    @classmethod
    def of(cls, screen: ScreenSpec) -> StripFormat:
        """Return the sizes for a screen."""
        by = _reduction(screen)
        by_x, by_y = _small_reduction(screen)
        return cls(
            screen.width // by, screen.height // by, screen.width // by_x, screen.height // by_y
        )


def strip_webp(recording: Recording, console: Console | None = None) -> bytes:
    """Return a recording's film strip, as a lossless WebP."""
    reel = Reel(recording)
    replay(recording, console, reel.add)
    return reel.webp()


class Reel:
    """Collects screens of a replay, at even intervals, and makes a film strip of them.

    Args:
        recording: The recording that is replayed.
    """

    def __init__(self, recording: Recording) -> None:
        self._screen = recording.game.screen
        even = np.linspace(0, recording.n_frames, _N_CANDIDATES)
        self._wanted = frozenset(np.rint(even).astype(int).tolist())
        self._frames: list[int] = []
        self._screens: list[Screen] = []

    def add(self, episode: Episode) -> None:
        """Collect the screen if its frame is one of the candidates."""
        if episode.frame in self._wanted or episode.end is not None:
            self._frames.append(episode.frame)
            self._screens.append(_reduced(self._screen, episode.console.screen()))

    def webp(self) -> bytes:
        """Return the film strip."""
        looks = np.stack([_look(self._screen, screen) for screen in self._screens])
        moments = [self._screens[one] for one in choose_moments(looks, np.array(self._frames))]
        sheet = Image.fromarray(_sheet(self._screen, moments))
        file = io.BytesIO()
        sheet.save(file, "WEBP", lossless=True, quality=20, method=2)
        return file.getvalue()


def choose_moments(
    looks: npt.NDArray[np.float32], frames: npt.NDArray[np.int64], count: int = N_MOMENTS
) -> list[int]:
    """Choose the moments of a game that differ most, by farthest-first traversal (Gonzalez 1985).

    Args:
        looks: What the moments look like, float32 (n, d), in order of time.
        frames: Their frames, int64 (n,), which differ.
        count: Number of moments to choose; some are chosen twice where there are fewer.

    Returns:
        Rows in order of time, the first and the last among them.
    """
    n = len(looks)
    if n <= count:
        return [int(row) for row in np.rint(np.linspace(0, n - 1, count))]
    # (n, n) distances, in units of the greatest.
    squares = np.sum(looks**2, axis=1)
    apart = np.sqrt(np.maximum(squares[:, None] + squares - 2 * looks @ looks.T, 0))
    apart /= max(float(apart.max()), 1e-6)
    times = frames / (frames[-1] - frames[0])
    apart = apart + _WEIGHT_OF_TIME * np.abs(times[:, None] - times)
    chosen = [0, n - 1]
    while len(chosen) < count:
        chosen.append(int(apart[chosen].min(axis=0).argmax()))
    return sorted(chosen)


def _look(spec: ScreenSpec, screen: Screen) -> npt.NDArray[np.float32]:
    """Return what a moment looks like without the score, float32 (d,), 0 to 255."""
    if spec.grayscale is None:
        gray = np.array(Image.fromarray(screen).convert("L"))
    else:
        gray = spec.grayscale[screen]
    by = _reduction(spec)
    for area in spec.hidden:
        gray[area.top // by : area.bottom // by, area.left // by : area.right // by] = 0
    small = Image.fromarray(gray).resize(_LOOK, Image.Resampling.BOX)
    return np.asarray(small, np.float32).ravel()


def _sheet(spec: ScreenSpec, moments: list[Screen]) -> Picture:
    """Return moments and reduced moments as `StripFormat` says, uint8 (height, width, 3) RGB."""
    size = StripFormat.of(spec)
    top = N_MOMENTS // COLUMNS * size.height
    height = top + N_MOMENTS // SMALL_COLUMNS * size.small_height
    width = max(COLUMNS * size.width, SMALL_COLUMNS * size.small_width)
    sheet = np.zeros((height, width, 3), np.uint8)
    for place, screen in enumerate(moments):
        row, column = divmod(place, COLUMNS)
        _paste(sheet, _colours(spec, screen), row * size.height, column * size.width)
        row, column = divmod(place, SMALL_COLUMNS)
        left = column * size.small_width
        _paste(sheet, _small(spec, screen), top + row * size.small_height, left)
    return sheet


def _paste(sheet: Picture, picture: Picture, top: int, left: int) -> None:
    height, width = picture.shape[:2]
    sheet[top : top + height, left : left + width] = picture


def _colours(spec: ScreenSpec, screen: Screen) -> Picture:
    """Return a screen in colours, as an array of its own."""
    return screen.copy() if spec.palette is None else spec.palette[screen]


def _reduction(spec: ScreenSpec) -> int:
    """Return the number of pixels, either way, that become one of a moment."""
    return 1 if spec.palette is not None else -(-spec.width // _WIDEST)


def _small_reduction(spec: ScreenSpec) -> tuple[int, int]:
    """Return the numbers of pixels side by side, and one above the other, that become a small one.

    Small pixels are about square.
    """
    by = -(-(spec.width // _reduction(spec)) // _SMALL_WIDEST)
    by_y = int(np.ceil(by * spec.pixel_aspect))
    return by * _reduction(spec), by_y * _reduction(spec)


def _reduced(spec: ScreenSpec, screen: Screen) -> Screen:
    """Return a screen as moments show it."""
    by = _reduction(spec)
    if by == 1:
        return screen
    size = StripFormat.of(spec)
    whole = screen[: size.height * by, : size.width * by]
    return np.asarray(Image.fromarray(whole).reduce(by))


def _small(spec: ScreenSpec, screen: Screen) -> Picture:
    """Return a reduced moment, RGB.

    Of the pixels that become one, that of the rarest colour on the screen stays, so that a ball or
    a shot does. A screen without a palette is averaged.
    """
    size = StripFormat.of(spec)
    by_x, by_y = (by // _reduction(spec) for by in _small_reduction(spec))
    height, width = size.small_height, size.small_width
    screen = screen[: height * by_y, : width * by_x]
    if spec.palette is None:
        return np.asarray(Image.fromarray(screen).reduce((by_x, by_y)))
    # (height, by_y, width, by_x) -> (height, width, by_y * by_x)
    blocks = screen.reshape(height, by_y, width, by_x).swapaxes(1, 2).reshape(height, width, -1)
    rarest = np.bincount(screen.ravel(), minlength=256)[blocks].argmin(axis=2)
    values = np.take_along_axis(blocks, rarest[..., None], axis=2)[..., 0]
    return np.asarray(spec.palette[values])
