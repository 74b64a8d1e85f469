"""Games as films: every screen as what changed since the one before, in one zlib stream.

docs/protocol.md describes the format, which ``frontend/src/features/share/film.ts`` reads.
"""

from __future__ import annotations

import io
import math
import time
import zlib
from dataclasses import dataclass

import numpy as np
from PIL import Image
from PIL.PngImagePlugin import PngInfo

from tril.games.base import Console, Game, Screen
from tril.play.episode import Episode
from tril.play.screens import joined
from tril.recording import Recording, RecordingRefused, replay

MAX_GAP_BYTES = 4
"""Unchanged bytes within a run of changed ones: to begin another run takes two or three."""
STILL_FRAMES = 2
"""Frames joined into a still, since flickering objects are drawn on every other frame."""


@dataclass(frozen=True)
class Film:
    """The screens of a game.

    Attributes:
        last: Number of the last frame; frame 0 is the screen at the start.
        frames_per_picture: Frames that each picture stands for; 1 shows every frame exactly.
        content: The pictures, see docs/protocol.md.
        still: A screen of the game, uint8 (height, width) or (height, width, 3).
    """

    last: int
    frames_per_picture: int
    content: bytes
    still: Screen


class FilmEncoder:
    """Encodes screens, each relative to the one before, the first relative to zeros."""

    def __init__(self, shape: tuple[int, ...]) -> None:
        """Make an encoder of screens of this shape."""
        self._before = np.zeros(shape, np.uint8).ravel()
        self._stream = zlib.compressobj(9)
        self._parts: list[bytes] = []

    def add(self, screen: Screen) -> None:
        """Append a screen; it is copied."""
        pixels = screen.flatten()
        self._parts.append(self._stream.compress(changes(self._before ^ pixels)))
        self._before = pixels

    def finish(self) -> bytes:
        """Return the film's content."""
        return b"".join([*self._parts, self._stream.flush()])


def changes(difference: Screen) -> bytes:
    """Return the bytes that are not zero as runs, each with its distance from the run before.

    Args:
        difference: Two screens XORed, uint8 (n,).
    """
    changed = np.flatnonzero(difference)
    if len(changed) == 0:
        return _number(0)
    cuts = np.flatnonzero(np.diff(changed) > MAX_GAP_BYTES)
    begins = changed[np.append(0, cuts + 1)]
    ends = changed[np.append(cuts, len(changed) - 1)] + 1
    parts, at = [_number(len(begins))], 0
    for begin, end in zip(begins.tolist(), ends.tolist(), strict=True):
        parts += [_number(begin - at), _number(end - begin), difference[begin:end].tobytes()]
        at = end
    return b"".join(parts)


class DeadlinePassed(Exception):
    """A film was not made in time.

    Attributes:
        share: Share of it that was made.
    """

    def __init__(self, share: float) -> None:
        super().__init__(f"{share:.0%} of a film was made in time.")
        self.share = share


def film_of(
    recording: Recording,
    still_frame: int,
    console: Console | None = None,
    *,
    frames_per_picture: int = 1,
    longest: int | None = None,
    deadline_s: float = math.inf,
) -> Film:
    """Return a recording as a film.

    Args:
        recording: The recording.
        still_frame: Frame of the still; the last one where the game is over before.
        console: A console of its game to replay on; None makes one.
        frames_per_picture: Frames that each picture stands for.
        longest: Last frame that is shown; None for the whole game.
        deadline_s: Time of `time.monotonic` by which it has to be made.

    Raises:
        RecordingRefused: Its replay differs from what was recorded.
        DeadlinePassed: It was not made by then.
    """
    shown = recording if longest is None else recording.until(min(longest, recording.n_frames))
    game = shown.game
    encoder = FilmEncoder(game.screen.shape)
    waiting: list[Screen] = []
    recent: list[Screen] = []

    def keep(episode: Episode) -> None:
        if time.monotonic() > deadline_s:
            raise DeadlinePassed(episode.frame / shown.n_frames)
        screen = episode.console.screen().copy()
        waiting.append(screen)
        if len(waiting) == frames_per_picture:
            encoder.add(joined(waiting, game.screen))
            waiting.clear()
        if episode.frame <= still_frame:
            recent[:] = [*recent, screen][-STILL_FRAMES:]

    played = replay(shown, console, keep)
    if waiting:
        encoder.add(joined(waiting, game.screen))
    if shown.hashes and played.hashes != shown.hashes[: len(played.hashes)]:
        raise RecordingRefused("A replay of this game differs from what was recorded.")
    still = joined(recent, game.screen)
    return Film(played.n_frames, frames_per_picture, encoder.finish(), still)


def picture_of(screen: Screen, game: Game) -> Image.Image:
    """Return a screen as a picture of its own size."""
    palette = game.screen.palette
    if palette is None:
        return Image.fromarray(screen).quantize(256, dither=Image.Dither.NONE)
    picture = Image.fromarray(screen)
    picture.putpalette(palette.tobytes())
    return picture


def png(picture: Image.Image, comment: str = "") -> bytes:
    """Return a picture as a PNG, with a comment in Latin-1."""
    file, texts = io.BytesIO(), PngInfo()
    if comment:
        texts.add_text("Comment", comment)
    picture.save(file, "PNG", optimize=True, pnginfo=texts)
    return file.getvalue()


def _number(value: int) -> bytes:
    """Return a number in groups of seven bits, the lowest first; all but the last have bit 7."""
    encoded = bytearray()
    while value > 127:
        encoded.append(value & 127 | 128)
        value >>= 7
    encoded.append(value)
    return bytes(encoded)
