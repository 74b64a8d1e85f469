"""Messages between a player's page and the server, see docs/protocol.md. Pure."""

from __future__ import annotations

import struct
from dataclasses import dataclass
from enum import IntEnum
from typing import Annotated, Literal, get_args

from pydantic import BaseModel, ConfigDict, Field, TypeAdapter, ValidationError

from server.play.conditions import Percent
from server.play.wire.codec import FLAG_KEY, EncodedFrame

MAX_UNACKNOWLEDGED = 6
MAX_MESSAGE_BYTES = 256
"""Limit of a page's message."""

FLAG_COUNTED = 2
"""Marks a FRAME if one of the game's counters has risen since the previous FRAME."""

MARKS_BYTES = 2
"""Bytes of a FRAME for the page's overlay of the game; zeros for games without one."""

_FRAME = struct.Struct("<BB2sIII")
_CLIENT = struct.Struct("<BBHI")
_LATENCY_UNIT_MS = 0.1
_BUTTONS_BITS = 8
"""Bits of the buttons in an INPUT's second byte; the third and the fourth hold further ones."""
_SEQUENCES = 2**32


class Close(IntEnum):
    """Codes with which the server closes a stream."""

    INTERNAL_ERROR = 1011
    TRY_AGAIN_LATER = 1013
    TAKEN_OVER = 4001
    BAD_MESSAGE = 4400
    NO_SUCH_GAME = 4404
    GAME_OVER = 4410


class BadMessage(ValueError):
    """A message that violates the protocol."""


@dataclass(frozen=True)
class FrameMessage:
    """Server to page: a screen.

    Attributes:
        sequence: Number of the frame on this connection, from 1.
        frame: Executed frames of the game; 0 is the start's screen.
        input_sequence: The newest input that a frame was executed with.
        encoded: The screen.
        marks: Overlay data of the frame; two bytes.
        has_counted: Whether one of the game's counters has risen since the previous FRAME.
    """

    sequence: int
    frame: int
    input_sequence: int
    encoded: EncodedFrame
    marks: bytes
    has_counted: bool


@dataclass(frozen=True)
class InputMessage:
    """Page to server: the buttons held from now on, as bits; ``sequence`` numbers the inputs."""

    buttons: int
    sequence: int


@dataclass(frozen=True)
class AckMessage:
    """Page to server: the frame of this sequence, and all before it, have been drawn.

    ``latency_ms`` is the time from a key's event to this drawing, in tenths, if the frame is the
    first drawn that was executed with the key pressed, else None.
    """

    sequence: int
    latency_ms: float | None = None


CommandType = Literal["ready", "stop", "pause", "go_on", "step", "rewind", "release"]


class PageMessage(BaseModel):
    """A text message of the page."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)


class Command(PageMessage):
    """Page to server: a player's command."""

    type: CommandType


class SetSpeed(PageMessage):
    """Page to server: the speed in percent of 60 frames/s, 25 to 100."""

    type: Literal["speed"] = "speed"
    percent: Percent


ClientMessage = InputMessage | AckMessage | Command | SetSpeed


def frame_bytes(message: FrameMessage) -> bytes:
    """Serialise a FRAME."""
    header = _FRAME.pack(
        1,
        FLAG_KEY * message.encoded.is_key | FLAG_COUNTED * message.has_counted,
        message.marks,
        message.sequence,
        message.frame,
        message.input_sequence % _SEQUENCES,
    )
    return header + message.encoded.payload


def parse_client(data: bytes | str) -> ClientMessage:
    """Parse a page's message.

    Raises:
        BadMessage: It violates the protocol; says how.
    """
    if len(data) > MAX_MESSAGE_BYTES:
        raise BadMessage(f"A message may have {MAX_MESSAGE_BYTES} bytes, got {len(data)}.")
    return _parse_command(data) if isinstance(data, str) else _parse_binary(data)


def _parse_binary(data: bytes) -> InputMessage | AckMessage:
    if len(data) != _CLIENT.size:
        raise BadMessage(f"Expected a message of {_CLIENT.size} bytes, got {len(data)}.")
    kind, buttons, latency, sequence = _CLIENT.unpack(data)
    if kind == 1:
        return InputMessage(buttons | latency << _BUTTONS_BITS, sequence)
    if kind == 2:
        return AckMessage(sequence, round(latency * _LATENCY_UNIT_MS, 1) if latency else None)
    raise BadMessage(f"Expected a message of type 1 (input) or 2 (acknowledgement), got {kind}.")


_COMMANDS: TypeAdapter[Command | SetSpeed] = TypeAdapter(
    Annotated[Command | SetSpeed, Field(discriminator="type")]
)


def _parse_command(text: str) -> Command | SetSpeed:
    try:
        return _COMMANDS.validate_json(text)
    except ValidationError as error:
        raise BadMessage(
            f'Expected {{"type": "ready"}} or another of {", ".join(get_args(CommandType))}, or'
            f' {{"type": "speed", "percent": 25 to 100}}, got {text[:80]!r}'
        ) from error


class Message(BaseModel):
    """A text message of the server."""

    model_config = ConfigDict(extra="forbid")

    def to_json(self) -> str:
        """Serialise the message."""
        return self.model_dump_json()


class HitAt(Message):
    """An item that was taken; rows and columns count from 0."""

    row: int
    column: int
    frame: int
    on_target: bool | None


class OverlayLayout(Message):
    """What the page may draw over the screens: a painter of its own, and constants in pixels."""

    painter: str
    geometry: dict[str, int]


class Hello(Message):
    """First message: how to draw the frames, and the state of the game.

    ``palette`` is None where screens are RGB.
    """

    type: Literal["hello"] = "hello"
    game: str
    palette: list[list[int]] | None
    width: int
    height: int
    frame_rate_hz: int
    max_frames: int
    frame: int
    epoch: int
    resumed: bool
    hits: list[HitAt]
    speed_percent: int
    overlay: OverlayLayout | None


class Countdown(Message):
    """Seconds until the game resumes; 0 when it does."""

    type: Literal["countdown"] = "countdown"
    seconds: int


class HitMessage(HitAt):
    """An item was taken; ``targets`` and ``strays`` so far, None without a target."""

    type: Literal["hit"] = "hit"
    targets: int | None
    strays: int | None


class Paused(Message):
    """The game is paused; ``why`` is shown to the player. "go_on" restarts the countdown."""

    type: Literal["paused"] = "paused"
    why: str


class Rewound(Message):
    """The game was rewound and resumes at this frame.

    ``recording_id`` is the recording of the game as it was before.
    """

    type: Literal["rewound"] = "rewound"
    frame: int
    hits: list[HitAt]
    recording_id: int


class Ended(Message):
    """The game is over, saved and verified. ``reason`` is None if it was stopped."""

    type: Literal["ended"] = "ended"
    reason: str | None
    frame: int
    hits: list[HitAt]
    targets: int | None
    strays: int | None
    order_errors: int | None
    recording_id: int
    verification: Literal["verified", "failed"]
    verification_note: str


class TakenOver(Message):
    """Another tab has taken over the game; the stream closes with 4001."""

    type: Literal["taken_over"] = "taken_over"


class Alive(Message):
    """Sent once a second: a page that receives nothing for longer has lost the connection."""

    type: Literal["alive"] = "alive"


ServerMessage = Hello | Countdown | HitMessage | Paused | Rewound | Ended | TakenOver | Alive
