"""The page's end of the protocol, for players in tests and benchmarks; see docs/protocol.md."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterator
from typing import Annotated

import numpy as np
from pydantic import Field, TypeAdapter, ValidationError

from server.play.replays.products import MAGIC
from server.play.wire.codec import FLAG_KEY, EncodedFrame
from server.play.wire.protocol import (
    FLAG_COUNTED,
    AckMessage,
    BadMessage,
    FrameMessage,
    InputMessage,
    ServerMessage,
)
from tril.games.base import Screen

_FRAME = struct.Struct("<BB2sIII")
_CLIENT = struct.Struct("<BBHI")
_FILE_LENGTH = struct.Struct("<I")
_FILE_FRAME = struct.Struct("<IB")
_MOST_TENTHS = 2**16 - 1
_SERVER_MESSAGES: TypeAdapter[ServerMessage] = TypeAdapter(
    Annotated[ServerMessage, Field(discriminator="type")]
)


class UnreadableFrame(ValueError):
    """Bytes that are not a frame of the codec."""


class FrameDecoder:
    """Decodes frames in the order in which they were encoded."""

    def __init__(self, shape: tuple[int, ...]) -> None:
        """Make a decoder of screens of this shape."""
        self._shape = shape
        self._n_bytes = int(np.prod(shape))
        self._before: Screen | None = None

    def decode(self, frame: EncodedFrame) -> Screen:
        """Return the screen, a fresh array.

        Raises:
            UnreadableFrame: The payload is malformed, or refers to a screen that was not decoded.
        """
        inflate = zlib.decompressobj()
        try:
            data = inflate.decompress(frame.payload, self._n_bytes + 1)
        except zlib.error as error:
            raise UnreadableFrame(f"A frame is no zlib stream: {error}.") from error
        if len(data) != self._n_bytes or not inflate.eof:
            raise UnreadableFrame(f"Expected a frame of {self._n_bytes} bytes, got {len(data)}.")
        screen = np.frombuffer(data, np.uint8).reshape(self._shape).copy()
        if not frame.is_key:
            if self._before is None:
                raise UnreadableFrame("The first frame has to be a key frame.")
            screen ^= self._before
        self._before = screen
        return screen.copy()


def read_frames_file(content: bytes) -> Iterator[EncodedFrame]:
    """Yield the frames of a file of frames, the start's screen first."""
    if content[: len(MAGIC)] != MAGIC:
        raise ValueError("Expected a file of frames, which begins with TRILFRM1.")
    at = len(MAGIC)
    at += _FILE_LENGTH.size + _FILE_LENGTH.unpack_from(content, at)[0]
    while at < len(content):
        length, flags = _FILE_FRAME.unpack_from(content, at)
        at += _FILE_FRAME.size
        yield EncodedFrame(bool(flags & FLAG_KEY), content[at : at + length])
        at += length


def parse_frame(data: bytes) -> FrameMessage:
    """Parse a FRAME; raises BadMessage."""
    if len(data) < _FRAME.size or data[0] != 1:
        raise BadMessage(f"Expected a frame of at least {_FRAME.size} bytes that begins with 1.")
    _, flags, marks, sequence, frame, input_sequence = _FRAME.unpack_from(data)
    encoded = EncodedFrame(bool(flags & FLAG_KEY), data[_FRAME.size :])
    return FrameMessage(sequence, frame, input_sequence, encoded, marks, bool(flags & FLAG_COUNTED))


def parse_server(text: str) -> ServerMessage:
    """Parse a text message of the server; raises BadMessage."""
    try:
        return _SERVER_MESSAGES.validate_json(text)
    except ValidationError as error:
        raise BadMessage(f"Expected a message of the server, got {text[:80]!r}.") from error


def client_bytes(message: InputMessage | AckMessage) -> bytes:
    """Serialise an INPUT or an ACK."""
    if isinstance(message, InputMessage):
        more, buttons = divmod(message.buttons, 1 << 8)
        return _CLIENT.pack(1, buttons, more, message.sequence)
    tenths = 0
    if message.latency_ms is not None:
        tenths = min(max(1, round(message.latency_ms * 10)), _MOST_TENTHS)
    return _CLIENT.pack(2, 0, tenths, message.sequence)
