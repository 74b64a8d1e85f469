"""Encodes recordings as GIF, WebP and MP4 at their original speed.

The pixels of an Atari 2600 are about twice as wide as high, so each becomes 2x1 pixels of the
clip. In a video, whose colours have half the resolution, every pixel is twice as large in both
directions.

MP4 has all frames. GIF counts in hundredths of a second and WebP in thousandths, so both have about
20 pictures a second. Of 60 frames, each picture is the pixel-wise brightest of three, as the
console draws some objects in every other frame only; sampled frames would show or hide them by
chance.
"""

from __future__ import annotations

import io
import tempfile
from collections.abc import Iterable, Iterator
from itertools import islice
from pathlib import Path

import av
import numpy as np
import numpy.typing as npt
from PIL import Image

from server.clips.request import ClipKind
from tril.games.base import Clock, Console, Screen, ScreenSpec
from tril.play.episode import Episode
from tril.play.screens import joined
from tril.recording import Recorder, Recording

PICTURES_PER_S = 20

CONSOLE_WIDTH_SCALE = 2
"""Width of an Atari's pixel by its height, in whole numbers."""
VIDEO_SCALE = 2
"""Enlargement of a video in either direction, so that its colours, which have half the resolution,
have that of the game's pixels."""

_CRF = "18"
"""x264's quality factor: visually lossless."""

# ITU-R BT.601, 8 bits, limited range: Y, Cb, Cr of red, green, blue in 0..1.
_YCBCR = np.array([[65.481, 128.553, 24.966], [-37.797, -74.203, 112.0], [112.0, -93.786, -18.214]])
_YCBCR_OFFSET = np.array([16, 128, 128])


def render(recording: Recording, kind: ClipKind, console: Console | None = None) -> bytes:
    """Return a recording as a file of this kind."""
    screen, clock = recording.game.screen, recording.game.clock
    frames = _frames(recording, console)
    if kind is ClipKind.MP4:
        return _mp4(frames, screen, clock.frame_rate_hz)
    n = frames_per_picture(clock)
    pictures = (_picture(frame, screen) for frame in _joined(frames, n, screen))
    picture_ms = n * 1000 // clock.frame_rate_hz
    if kind is ClipKind.GIF:
        return _animated(pictures, "GIF", picture_ms, optimize=False, disposal=1)
    # For lossless files, quality is the effort of compression.
    rgb = (picture.convert("RGB") for picture in pictures)
    return _animated(rgb, "WEBP", picture_ms, lossless=True, quality=20, method=0)


def frames_per_picture(clock: Clock) -> int:
    """Return the number of frames that a picture of a GIF or WebP stands for."""
    return max(1, round(clock.frame_rate_hz / PICTURES_PER_S))


def _frames(recording: Recording, console: Console | None) -> Iterator[Screen]:
    """Yield the screens at the start and after every frame."""
    console = console or recording.game.make_console()
    console.game = recording.game
    recorder = Recorder(Episode(console, recording.start, recording.end_rule))
    yield console.screen()
    for action in recording.actions:
        if recorder.episode.end is not None:
            return
        recorder.advance(action)
        yield console.screen()


def _joined(frames: Iterator[Screen], n: int, screen: ScreenSpec) -> Iterator[Screen]:
    """Yield one screen for every n successive ones: the brightest, or the last where RGB."""
    while among := list(islice(frames, n)):
        yield joined(among, screen)


def _picture(pixels: Screen, screen: ScreenSpec) -> Image.Image:
    if screen.palette is None:
        return Image.fromarray(pixels)
    picture = Image.fromarray(pixels.repeat(CONSOLE_WIDTH_SCALE, axis=1))
    picture.putpalette(screen.palette.tobytes())
    return picture


def _animated(
    pictures: Iterator[Image.Image], form: str, picture_ms: int, **options: object
) -> bytes:
    file = io.BytesIO()
    first = next(pictures)
    first.save(
        file,
        form,
        save_all=True,
        append_images=pictures,
        duration=picture_ms,
        loop=0,
        **options,
    )
    return file.getvalue()


def _mp4(frames: Iterable[Screen], screen: ScreenSpec, frame_rate_hz: int) -> bytes:
    width_scale = 1 if screen.palette is None else CONSOLE_WIDTH_SCALE
    table = None if screen.palette is None else _ycbcr(screen.palette)
    # faststart moves the index to the beginning, for which the output has to be seekable.
    with tempfile.TemporaryDirectory(prefix="tril-clip-") as folder:
        place = Path(folder) / "clip.mp4"
        with av.open(str(place), "w", options={"movflags": "faststart"}) as file:
            stream = file.add_stream("libx264", rate=frame_rate_hz)
            stream.width = screen.width * width_scale * VIDEO_SCALE
            stream.height = screen.height * VIDEO_SCALE
            stream.pix_fmt = "yuv420p"
            stream.options = {"crf": _CRF, "preset": "veryfast"}
            stream.codec_context.thread_count = 1
            for frame in frames:
                colours = _ycbcr(frame) if table is None else table[:, frame]
                planes = _planes(colours.repeat(width_scale, axis=2))
                file.mux(stream.encode(av.VideoFrame.from_ndarray(planes, format="yuv420p")))
            file.mux(stream.encode())
        return place.read_bytes()


def _planes(colours: npt.NDArray[np.uint8]) -> npt.NDArray[np.uint8]:
    """Return Y at twice the resolution, then Cb and Cr, below each other.

    Args:
        colours: Y, Cb, Cr, uint8 (3, height, width).

    Returns:
        uint8 (3 * height, 2 * width).
    """
    y = colours[0].repeat(VIDEO_SCALE, axis=1).repeat(VIDEO_SCALE, axis=0)
    return np.concatenate([y.reshape(-1), colours[1:].reshape(-1)]).reshape(-1, y.shape[1])


def _ycbcr(rgb: npt.NDArray[np.uint8]) -> npt.NDArray[np.uint8]:
    """Return colours, uint8 (..., 3) RGB, in BT.601, uint8 (3, ...): Y, Cb, Cr."""
    values = rgb / 255 @ _YCBCR.T + _YCBCR_OFFSET
    return np.moveaxis(np.rint(values).astype(np.uint8), -1, 0)
