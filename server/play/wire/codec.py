"""Screens to few bytes and back: XOR with the screen sent before, then zlib at its fastest.

docs/protocol.md describes the format; streams and recorded frames share it. Pure: no sockets.
"""

from __future__ import annotations

import zlib
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from tril.game.space_invaders import SCREEN_SHAPE

Screen = npt.NDArray[np.uint8]
"""A screen, uint8 (210, 160) of palette values."""

SCREEN_BYTES = SCREEN_SHAPE[0] * SCREEN_SHAPE[1]
ZLIB_LEVEL = 1


class UnreadableFrame(ValueError):
    """Bytes that are no frame of this codec."""


@dataclass(frozen=True)
class EncodedFrame:
    """One screen as it travels.

    Attributes:
        is_key: Whether it can be decoded without the screen before.
        payload: zlib stream of 33,600 bytes: the palette values, row by row from the top, XOR those
            of the screen encoded before (of nothing but zeros in a key frame).
    """

    is_key: bool
    payload: bytes


class FrameEncoder:
    """Encodes screens one after the other; each refers to the one encoded before."""

    def __init__(self) -> None:
        self._before: Screen = np.zeros(SCREEN_SHAPE, np.uint8)
        self._delta: Screen = np.empty(SCREEN_SHAPE, np.uint8)
        self._needs_key = True

    def encode(self, screen: Screen, key: bool = False) -> EncodedFrame:
        """Encode a screen.

        Args:
            screen: uint8 (210, 160) of palette values; it is copied.
            key: Whether it shall not refer to the screen before; the first one never does.
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
            UnreadableFrame: It is no frame, or it refers to a screen that was not decoded.
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
