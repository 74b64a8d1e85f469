"""Screen codec: XOR with the previous screen, then zlib at its fastest.

docs/protocol.md describes the format, which streams and recorded frames share. Pure: no sockets.
"""

from __future__ import annotations

import zlib
from dataclasses import dataclass

import numpy as np

from tril.games.base import Screen, ScreenSpec

ZLIB_LEVEL = 1
FLAG_KEY = 1
"""Marks a key frame, in a stream's FRAME and in a file of frames."""


@dataclass(frozen=True)
class EncodedFrame:
    """One encoded screen.

    Attributes:
        is_key: Whether the frame decodes without the previous screen.
        payload: zlib stream of the screen's bytes: palette values, or red, green and blue, row by
            row from the top, XOR those of the previous screen (all zeros for a key frame).
    """

    is_key: bool
    payload: bytes


class FrameEncoder:
    """Encodes a sequence of screens, each relative to the one before."""

    def __init__(self, shape: tuple[int, ...]) -> None:
        """Make an encoder of screens of this shape."""
        self._before: Screen = np.zeros(shape, np.uint8)
        self._delta: Screen = np.empty(shape, np.uint8)
        self._needs_key = True

    def encode(self, screen: Screen, key: bool = False) -> EncodedFrame:
        """Encode a screen.

        Args:
            screen: The screen; it is copied.
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


def palette_json(screen: ScreenSpec) -> list[list[int]] | None:
    """Return the colour of each palette value, [[r, g, b]] * 256; None for RGB screens."""
    return None if screen.palette is None else screen.palette.tolist()
