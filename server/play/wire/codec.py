"""Screen codec: XOR with the previous screen, then zlib at its fastest.

docs/protocol.md describes the format, which streams and recorded frames share. Pure: no sockets.
"""

from __future__ import annotations

import zlib
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from tril.games.atari.palette import palette_rgb
from tril.games.space_invaders.memory import SCREEN_SHAPE

Screen = npt.NDArray[np.uint8]
"""A screen, uint8 (210, 160) of palette values."""

SCREEN_BYTES = SCREEN_SHAPE[0] * SCREEN_SHAPE[1]
ZLIB_LEVEL = 1
FLAG_KEY = 1
"""Marks a key frame, in a stream's FRAME and in a file of frames."""


class UnreadableFrame(ValueError):
    """Bytes that are not a frame of this codec."""


@dataclass(frozen=True)
class EncodedFrame:
    """One encoded screen.

    Attributes:
        is_key: Whether it decodes without the previous screen.
        payload: zlib stream of 33,600 bytes: the palette values, row by row from the top, XOR those
            of the previous screen (all zeros for a key frame).
    """

    is_key: bool
    payload: bytes


class FrameEncoder:
    """Encodes a sequence of screens, each relative to the one before."""

    def __init__(self) -> None:
        self._before: Screen = np.zeros(SCREEN_SHAPE, np.uint8)
        self._delta: Screen = np.empty(SCREEN_SHAPE, np.uint8)
        self._needs_key = True

    def encode(self, screen: Screen, key: bool = False) -> EncodedFrame:
        """Encode a screen.

        Args:
            screen: uint8 (210, 160) of palette values; it is copied.
            key: Whether to encode a key frame; the first frame always is one.
        """
        is_key = key or self._needs_key
        if is_key:
            payload = zlib.compress(screen.tobytes(), ZLIB_LEVEL)
        else:
            np.bitwise_xor(screen, self._before, out=self._delta)
            payload = zlib.compress(self._delta.data, ZLIB_LEVEL)
        self._before[:] = screen
        self._needs_key = False
        return EncodedFrame(is_key, payload)


class FrameDecoder:
    """Decodes frames in the order in which they were encoded."""

    def __init__(self) -> None:
        self._before: Screen | None = None

    def decode(self, frame: EncodedFrame) -> Screen:
        """Return the screen, uint8 (210, 160) of palette values, a fresh array.

        Raises:
            UnreadableFrame: The payload is malformed, or refers to a screen that was not decoded.
        """
        inflate = zlib.decompressobj()
        try:
            data = inflate.decompress(frame.payload, SCREEN_BYTES + 1)
        except zlib.error as error:
            raise UnreadableFrame(f"A frame is no zlib stream: {error}.") from error
        if len(data) != SCREEN_BYTES or not inflate.eof:
            raise UnreadableFrame(f"Expected a frame of {SCREEN_BYTES} bytes, got {len(data)}.")
        screen = np.frombuffer(data, np.uint8).reshape(SCREEN_SHAPE).copy()
        if not frame.is_key:
            if self._before is None:
                raise UnreadableFrame("The first frame has to be a key frame.")
            screen ^= self._before
        self._before = screen
        return screen.copy()


def palette_json() -> list[list[int]]:
    """Return the colour of each palette value, [[r, g, b]] * 256."""
    colours: list[list[int]] = palette_rgb().tolist()
    return colours
