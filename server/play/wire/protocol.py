"""Messages between a player's page and the server, see docs/protocol.md. Pure."""

from __future__ import annotations

import struct
from dataclasses import dataclass
from enum import IntEnum
from typing import Annotated, Literal, get_args

from pydantic import BaseModel, ConfigDict, Field, TypeAdapter, ValidationError

from server.play.conditions import Percent
from server.play.wire.codec import FLAG_KEY, EncodedFrame
from tril.games.space_invaders.controls import Keys
from tril.games.space_invaders.grid import Formation

MAX_UNACKNOWLEDGED = 6
MAX_MESSAGE_BYTES = 256
"""Limit of a page's message."""

FLAG_SHOT = 2
"""Marks a FRAME if a missile has left the cannon since the previous FRAME."""

_FRAME = struct.Struct("<BBBBIII")
_LEFT_BIAS_PX = 96
"""Offset of the first column's position, which can be up to six columns of 16 px off the screen."""
_BYTE = 2**8
_CLIENT = struct.Struct("<BBHI")
_LATENCY_UNIT_MS = 0.1
_LONGEST_LATENCY = 2**16 - 1
_ALL_KEYS = Keys.LEFT | Keys.RIGHT | Keys.FIRE
_SEQUENCES = 2**32


class Close(IntEnum):
    """Codes with which the server closes a stream."""

    INTERNAL_ERROR = 1011
    TRY_AGAIN_LATER = 1013
    TAKEN_OVER = 4001
    BAD_MESSAGE = 4400
    UNAUTHORISED = 4401
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
        formation: Position of the grid of aliens, px: left -96 to 159, top 0 to 255.
        is_shot: Whether a missile has left the cannon since the previous FRAME.
    """

    sequence: int
    frame: int
    input_sequence: int
    encoded: EncodedFrame
    formation: Formation
    is_shot: bool


@dataclass(frozen=True)
class InputMessage:
    """Page to server: the keys held from now on; ``sequence`` numbers the page's inputs."""

    keys: Keys
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
        FLAG_KEY * message.encoded.is_key | FLAG_SHOT * message.is_shot,
        (message.formation.left + _LEFT_BIAS_PX) % _BYTE,
        message.formation.top % _BYTE,
        message.sequence,
        message.frame,
        message.input_sequence % _SEQUENCES,
    )
    return header + message.encoded.payload


def parse_frame(data: bytes) -> FrameMessage:
    """Parse a FRAME; raises BadMessage."""
    if len(data) < _FRAME.size or data[0] != 1:
        raise BadMessage(f"Expected a frame of at least {_FRAME.size} bytes that begins with 1.")
    _, flags, left, top, sequence, frame, input_sequence = _FRAME.unpack_from(data)
    encoded = EncodedFrame(bool(flags & FLAG_KEY), data[_FRAME.size :])
    formation = Formation(left - _LEFT_BIAS_PX, top)
    return FrameMessage(
        sequence, frame, input_sequence, encoded, formation, bool(flags & FLAG_SHOT)
    )


def client_bytes(message: InputMessage | AckMessage) -> bytes:
    """Serialise an INPUT or an ACK."""
    if isinstance(message, InputMessage):
        return _CLIENT.pack(1, int(message.keys), 0, message.sequence)
    latency = 0
    if message.latency_ms is not None:
        latency = min(max(1, round(message.latency_ms / _LATENCY_UNIT_MS)), _LONGEST_LATENCY)
    return _CLIENT.pack(2, 0, latency, message.sequence)


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
    kind, keys, latency, sequence = _CLIENT.unpack(data)
    if kind == 1:
        if keys & ~int(_ALL_KEYS):
            raise BadMessage(f"Expected keys from 0 to {int(_ALL_KEYS)}, got {keys}.")
        return InputMessage(Keys(keys), sequence)
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
    """An alien that was shot; rows and columns count from 0."""

    row: int
    column: int
    frame: int
    on_target: bool | None


class AlienGeometry(Message):
    """Size of an alien and pitch of columns and rows, in pixels."""

    width: int
    height: int
    column_px: int
    row_px: int


class Hello(Message):
    """First message: how to draw the frames, and the state of the game."""

    type: Literal["hello"] = "hello"
    palette: list[list[int]]
    width: int
    height: int
    frame_rate_hz: int
    max_frames: int
    frame: int
    epoch: int
    resumed: bool
    hits: list[HitAt]
    speed_percent: int
    aliens: AlienGeometry


class Countdown(Message):
    """Seconds until the game resumes; 0 when it does."""

    type: Literal["countdown"] = "countdown"
    seconds: int


class HitMessage(HitAt):
    """An alien was shot; ``targets`` and ``strays`` so far, None without a target."""

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
_SERVER_MESSAGES: TypeAdapter[ServerMessage] = TypeAdapter(
    Annotated[ServerMessage, Field(discriminator="type")]
)


def parse_server(text: str) -> ServerMessage:
    """Parse a text message of the server; raises BadMessage."""
    try:
        return _SERVER_MESSAGES.validate_json(text)
    except ValidationError as error:
        raise BadMessage(f"Expected a message of the server, got {text[:80]!r}.") from error
