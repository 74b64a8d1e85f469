"""Encodes recordings as GIF, WebP and MP4 at their original speed.

The console's pixels are about twice as wide as high, so each becomes 2x1 pixels of the clip, or 4x2
in a video, whose colours have half the resolution.

MP4 has all 60 frames a second. GIF counts in hundredths of a second and WebP in thousandths, so
both have 20 pictures a second, each the pixel-wise brightest of three frames. The console draws
some objects in every other frame only; sampled frames would show or hide them by chance.
"""

from __future__ import annotations

import io
import tempfile
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path

import av
import numpy as np
import numpy.typing as npt
from PIL import Image

from server.clips.request import ClipKind
from tril.games.atari.palette import palette_grayscale, palette_rgb
from tril.games.base import Console
from tril.games.space_invaders import memory as game
from tril.play.episode import Episode
from tril.recording import Recording, replay

Screens = npt.NDArray[np.uint8]
"""Palette values, uint8 (n, 210, 160)."""

FRAMES_PER_PICTURE = 3
PICTURE_MS = FRAMES_PER_PICTURE * 1000 // game.FRAME_RATE_HZ

WIDTH_SCALE = 2
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
    make: dict[ClipKind, Callable[[Screens], bytes]] = {
        ClipKind.GIF: _gif,
        ClipKind.WEBP: _webp,
        ClipKind.MP4: _mp4,
    }
    return make[kind](_screens(recording, console))


def brightest(screens: Screens, n: int = FRAMES_PER_PICTURE) -> Screens:
    """Return the pixel-wise brightest of every n successive screens, ceil(len / n) screens."""
    gray = palette_grayscale()
    shown = np.empty((-(-len(screens) // n), *screens.shape[1:]), np.uint8)
    for index, picture in enumerate(shown):
        among = screens[index * n : (index + 1) * n]
        at = gray[among].argmax(axis=0)[None]
        picture[:] = np.take_along_axis(among, at, axis=0)[0]
    return shown


def _screens(recording: Recording, console: Console | None) -> Screens:
    screens = np.empty((recording.n_frames + 1, *game.SCREEN_SHAPE), np.uint8)

    def look(episode: Episode) -> None:
        episode.console.screen(screens[episode.frame])

    played = replay(recording, console, look)
    return screens[: played.n_frames + 1]


def _gif(screens: Screens) -> bytes:
    colours = palette_rgb().tobytes()

    def pictures() -> Iterator[Image.Image]:
        for screen in brightest(screens):
            picture = Image.fromarray(screen.repeat(WIDTH_SCALE, axis=1))
            picture.putpalette(colours)
            yield picture

    return _animated(pictures(), "GIF", optimize=False, disposal=1)


def _webp(screens: Screens) -> bytes:
    colours = palette_rgb()

    def pictures() -> Iterator[Image.Image]:
        for screen in brightest(screens):
            yield Image.fromarray(colours[screen.repeat(WIDTH_SCALE, axis=1)])

    # For lossless files, quality is the effort of compression.
    return _animated(pictures(), "WEBP", lossless=True, quality=20, method=0)


def _animated(pictures: Iterator[Image.Image], form: str, **options: object) -> bytes:
    file = io.BytesIO()
    first = next(pictures)
    first.save(
        file,
        form,
        save_all=True,
        append_images=pictures,
        duration=PICTURE_MS,
        loop=0,
        **options,
    )
    return file.getvalue()


def _mp4(screens: Screens) -> bytes:
    # faststart moves the index to the beginning, for which the output has to be seekable.
    with tempfile.TemporaryDirectory(prefix="tril-clip-") as folder:
        place = Path(folder) / "clip.mp4"
        with av.open(str(place), "w", options={"movflags": "faststart"}) as file:
            stream = file.add_stream("libx264", rate=game.FRAME_RATE_HZ)
            height, width = game.SCREEN_SHAPE
            stream.width = width * WIDTH_SCALE * VIDEO_SCALE
            stream.height = height * VIDEO_SCALE
            stream.pix_fmt = "yuv420p"
            stream.options = {"crf": _CRF, "preset": "veryfast"}
            stream.codec_context.thread_count = 1
            for screen in screens:
                frame = av.VideoFrame.from_ndarray(_planes(screen), format="yuv420p")
                file.mux(stream.encode(frame))
            file.mux(stream.encode())
        return place.read_bytes()


def _planes(screen: npt.NDArray[np.uint8]) -> npt.NDArray[np.uint8]:
    """Y, then Cb and Cr at half the resolution, below each other: uint8 (height * 3/2, width)."""
    luma, *chroma = palette_ycbcr()[:, screen]
    y = luma.repeat(WIDTH_SCALE * VIDEO_SCALE, axis=1).repeat(VIDEO_SCALE, axis=0)
    parts = [y, *(plane.repeat(WIDTH_SCALE, axis=1) for plane in chroma)]
    return np.concatenate([part.reshape(-1) for part in parts]).reshape(-1, y.shape[1])


@cache
def palette_ycbcr() -> npt.NDArray[np.uint8]:
    """Return the palette in BT.601, uint8 (3, 256): Y, Cb, Cr by palette value."""
    values = palette_rgb() / 255 @ _YCBCR.T + _YCBCR_OFFSET
    colours: npt.NDArray[np.uint8] = np.rint(values).astype(np.uint8).T.copy()
    colours.setflags(write=False)
    return colours
