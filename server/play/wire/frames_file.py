"""All frames of a recording in one file, and its thumbnail, by one replay each.

docs/protocol.md describes the file.
"""

from __future__ import annotations

import io
import json
import struct
from collections.abc import Iterator

import numpy as np
import numpy.typing as npt
from PIL import Image

from server.play.wire.codec import EncodedFrame, FrameEncoder, Screen
from tril.game import space_invaders as game
from tril.game.console import Console
from tril.game.episode import Episode
from tril.game.palette import palette_rgb
from tril.recording import Recording, replay

MAGIC = b"TRILFRM1"
KEY_EVERY_FRAMES = 60
FLAG_KEY = 1
_LENGTH = struct.Struct("<I")
_FRAME = struct.Struct("<IB")


def palette_json() -> list[list[int]]:
    """Return the colours by palette value, [[r, g, b]] * 256, as they travel."""
    colours: list[list[int]] = palette_rgb().tolist()
    return colours


def frames_file(recording: Recording, console: Console | None = None) -> bytes:
    """Return every frame of a recording, its start's screen first."""
    encoder = FrameEncoder()
    parts: list[bytes] = []

    def look(episode: Episode) -> None:
        frame = encoder.encode(
            episode.console.screen_palette(), key=episode.frame % KEY_EVERY_FRAMES == 0
        )
        parts.append(_FRAME.pack(len(frame.payload), FLAG_KEY * frame.is_key) + frame.payload)

    played = replay(recording, console, look)
    height, width = game.SCREEN_SHAPE
    header = json.dumps(
        {
            "width": width,
            "height": height,
            "palette": palette_json(),
            "frame_rate_hz": game.FRAME_RATE_HZ,
            "n_frames": played.n_frames,
            "key_every": KEY_EVERY_FRAMES,
        },
        separators=(",", ":"),
    ).encode()
    return b"".join([MAGIC, _LENGTH.pack(len(header)), header, *parts])


def read_frames_file(content: bytes) -> Iterator[EncodedFrame]:
    """Yield the frames of such a file, the start's screen first."""
    if content[: len(MAGIC)] != MAGIC:
        raise ValueError("Expected a file of frames, which begins with TRILFRM1.")
    at = len(MAGIC)
    at += _LENGTH.size + _LENGTH.unpack_from(content, at)[0]
    while at < len(content):
        length, flags = _FRAME.unpack_from(content, at)
        at += _FRAME.size
        yield EncodedFrame(bool(flags & FLAG_KEY), content[at : at + length])
        at += length


def thumbnail_png(recording: Recording, console: Console | None = None) -> bytes:
    """Return a PNG of the moment after a recording's last hit, or of its last frame."""
    shown: Screen = np.zeros(game.SCREEN_SHAPE, np.uint8)
    hits = 0

    def look(episode: Episode) -> None:
        nonlocal hits
        is_last = episode.frame == recording.n_frames or episode.end is not None
        if len(episode.hits) > hits or (is_last and not hits):
            hits = len(episode.hits)
            episode.console.screen_palette(shown)

    replay(recording, console, look)
    return png(palette_rgb()[shown])


def png(pixels: npt.NDArray[np.uint8]) -> bytes:
    """Return a PNG of an image, uint8 (height, width, 3) RGB."""
    file = io.BytesIO()
    image = Image.fromarray(pixels).quantize(256, dither=Image.Dither.NONE)
    image.save(file, "PNG", optimize=True)
    return file.getvalue()
