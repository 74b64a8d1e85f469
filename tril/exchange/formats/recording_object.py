"""The form of one recording in the exchange format: the model, its schema, and its refusals."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, BaseModel, BeforeValidator, ConfigDict, Field, ValidationError

from tril.game.space_invaders import COLUMNS, MAX_IDLE_FRAMES, ROWS
from tril.recording import RecordingRefused

FORMAT = "tril-recording"
VERSION = 1
MAX_NOTES_LENGTH = 4000
MAX_DEPTH = 16
"""Levels of nesting in what a recording carries along."""

Source = Literal["person", "scripted", "policy"]
"""Who played a recording."""

Cell = Annotated[list[Annotated[int, Field(ge=0, lt=ROWS)]], Field(min_length=2, max_length=2)]
# Base64 of one or more bytes from 0 to 5 and nothing else: the first six bits of a byte are 0 or
# 1, and so on. Held against the decoder by the tests.
_BYTE = "(?:A[AQgw]|B[AQ])"
_ACTIONS = f"^(?:{_BYTE}[AEIMQU][A-F])*(?:{_BYTE}[AEIMQU][A-F]|{_BYTE}[AEIMQU]=|{_BYTE}==)$"


def number(value: object) -> object:
    """Tell true from 1, which Python and a Literal do not."""
    if isinstance(value, bool):
        raise ValueError("expected a number")
    return value


def bounded(value: object) -> object:
    """Refuse what is nested so deeply that reading or showing it could fail."""
    level: list[object] = [value]
    for _ in range(MAX_DEPTH):
        level = [
            inner
            for outer in level
            if isinstance(outer, dict | list)
            for inner in (outer.values() if isinstance(outer, dict) else outer)
        ]
        if not level:
            return value
    raise ValueError(f"expected at most {MAX_DEPTH} levels of nesting")


class StrictModel(BaseModel):
    """Takes each member as it is, 1 for true never; members that it does not name are kept."""

    model_config = ConfigDict(strict=True, extra="allow")


class StartObject(StrictModel):
    """How the game began."""

    model_config = ConfigDict(title="Start")

    idle_frames: int = Field(
        ge=0,
        le=MAX_IDLE_FRAMES,
        description="Frames without a key after the 128 frames of the intro.",
    )
    mode: Annotated[Literal[0], BeforeValidator(number)] = Field(
        default=0, description="The cartridge's game mode."
    )
    difficulty: Annotated[Literal[0, 1], BeforeValidator(number)] = Field(
        default=0, description="The difficulty switch."
    )


class RecordingObject(StrictModel):
    """One recording of Tril, see exchange-format.md. Unknown members are ignored with a notice."""

    model_config = ConfigDict(title="Tril recording")

    format: Literal["tril-recording"]
    version: Annotated[Literal[1], BeforeValidator(number)]
    game: Literal["space_invaders"]
    rom_md5: str = Field(
        pattern="^[0-9a-f]{32}$", description="MD5 of the ROM that the game was played on."
    )
    start: StartObject
    ending: Literal["hit", "life_counter"] | None = Field(
        default=None,
        description="Which rule for the player's death ends the episode: hit, the default, at the"
        " hit itself; life_counter, about 130 frames later, where the game counts a life less.",
    )
    actions: str = Field(
        pattern=_ACTIONS,
        description="Base64 of one byte per frame: 0 NOOP, 1 FIRE, 2 RIGHT, 3 LEFT, 4 RIGHTFIRE,"
        " 5 LEFTFIRE. The first is executed at frame 128 + idle_frames after reset.",
    )
    hits: list[Cell] | None = Field(
        default=None,
        max_length=ROWS * COLUMNS,
        description="Aliens shot, in order of time: [row from the bottom, column from the left],"
        " from 0. Checked by a replay.",
    )
    tier: int | None = Field(
        default=None,
        ge=0,
        le=2**31 - 1,
        description="Place in a ranking, a lower number being better; equal numbers are a tie.",
    )
    perfect: bool | None = Field(default=None, description="Whether a clone should learn from it.")
    source: Source | None = Field(default=None, description="Who played it.")
    end: Any = Field(
        default=None,
        description="Why the episode ended: hit, lives, landed, cleared or steps; none of them"
        " where the recording ends before its episode. Compared with a replay; a difference is a"
        " notice.",
    )
    ram_hashes: list[Annotated[str, Field(pattern="^[0-9a-f]{16}$")]] | None = Field(
        default=None,
        max_length=10_000,
        description="BLAKE2b (8 bytes, hexadecimal) of the 128 bytes of RAM after every 60th"
        " frame. Checked by a replay.",
    )
    conditions: Annotated[dict[str, Any] | None, AfterValidator(bounded)] = Field(
        default=None, description="Anything about how it was played; kept as it is."
    )
    parent: Annotated[dict[str, Any] | str | None, AfterValidator(bounded)] = Field(
        default=None, description="The recording that this one goes on from; kept as it is."
    )
    notes: str | None = Field(
        default=None, max_length=MAX_NOTES_LENGTH, description="A person's remarks."
    )


def parse(content: object) -> RecordingObject:
    """Check the form of an object in the exchange format, as the schema does; nothing is played.

    Raises:
        RecordingRefused: It is not of this format; the message names each member that is wrong.
    """
    if not isinstance(content, dict):
        raise RecordingRefused(
            f"Expected one JSON object per recording, got {shortened(repr(content))}."
        )
    try:
        return RecordingObject.model_validate(plain(content))
    except RecursionError:
        raise RecordingRefused("It is nested too deeply to be a recording.") from None
    except ValidationError as error:
        raise RecordingRefused(" ".join(reasons(error))) from None


def schema() -> dict[str, Any]:
    """The JSON Schema (2020-12) of one recording."""
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        **RecordingObject.model_json_schema(),
    }


def plain(content: Any, keep_numbers: bool = False) -> Any:
    """Turn 1.0 into 1, since JSON knows one kind of number, and refuse what can't be stored.

    Args:
        content: Parsed JSON.
        keep_numbers: Whether numbers stay as they are.

    Raises:
        RecordingRefused: A number is infinite, or a text holds half a character or a zero.
    """
    match content:
        case float() if not math.isfinite(content):
            raise RecordingRefused("A number in it is too large.")
        case float() if content.is_integer() and not keep_numbers:
            return int(content)
        case str() if "\0" in content or any("\ud800" <= char <= "\udfff" for char in content):
            raise RecordingRefused(f"This text can't be stored: {shortened(ascii(content))}.")
        case dict():
            return {
                plain(key): plain(value, keep_numbers or key == "conditions")
                for key, value in content.items()
            }
        case list():
            return [plain(value, keep_numbers) for value in content]
    return content


def reasons(error: ValidationError) -> Iterator[str]:
    """Say what is wrong, a sentence for each of the first few members."""
    problems = error.errors(include_url=False)
    for problem in problems[:4]:
        place = ".".join(str(part) for part in problem["loc"])
        got = shortened(repr(problem["input"]))
        match problem["type"], place:
            case "missing", _:
                yield f"{place} is missing."
            case "string_pattern_mismatch", "actions":
                yield (
                    "actions: expected base64 of one byte from 0 to 5 per frame and at least one"
                    f" frame, got {got}."
                )
            case "literal_error", "start.mode":
                yield (
                    f"start.mode: expected 0, got {got}. Reading the aliens is only tested in"
                    " mode 0, so games in other modes are not accepted."
                )
            case _:
                message = problem["msg"].replace("Input should be", "expected")
                message = message.removeprefix("Value error, ")
                yield f"{place}: {message}, got {got}."
    if len(problems) > 4:
        yield f"And {len(problems) - 4} more."


def shortened(content: object, length: int = 60) -> str:
    """Show a value that somebody sent, in at most so many characters."""
    text = content if isinstance(content, str) else repr(content)
    return text if len(text) <= length else f"{text[: length - 1]}…"
