"""The model of a recording in the exchange format, its schema, and its error messages."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from datetime import UTC, datetime
from typing import Annotated, Any, Literal

from pydantic import (
    AfterValidator,
    AwareDatetime,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    ValidationError,
)

from tril.games.atari.starts import MAX_IDLE_FRAMES
from tril.games.space_invaders.memory import COLUMNS, ROWS
from tril.recording import RecordingRefused
from tril.text import TextRefused, clean_line, clean_lines

FORMAT = "tril-recording"
VERSION = 1
MAX_NOTES_LENGTH = 4000
FIRST_YEAR, LAST_YEAR = 1970, 9998
MAX_DEPTH = 16
"""Maximum nesting of conditions and parent."""

Source = Literal["person", "scripted", "policy", "varied"]
"""Who played a recording; random: nobody, its actions were drawn at random."""

CellArray = Annotated[list[Annotated[int, Field(ge=0, lt=ROWS)]], Field(min_length=2, max_length=2)]


def _in_utc(moment: datetime) -> datetime:
    # Not the first and the last year, which other time zones put out of all calendars.
    if not FIRST_YEAR <= moment.year <= LAST_YEAR:
        raise ValueError(f"expected a time from {FIRST_YEAR} to {LAST_YEAR}")
    return moment.astimezone(UTC)


Moment = Annotated[AwareDatetime, AfterValidator(_in_utc)]
"""A time in UTC."""

# Base64 of one or more bytes from 0 to 5; tested against the decoder.
_BYTE = "(?:A[AQgw]|B[AQ])"
_ACTIONS = f"^(?:{_BYTE}[AEIMQU][A-F])*(?:{_BYTE}[AEIMQU][A-F]|{_BYTE}[AEIMQU]=|{_BYTE}==)$"


def reject_bool(value: object) -> object:
    """Reject True and False, which a Literal takes for 1 and 0."""
    if isinstance(value, bool):
        raise ValueError("expected a number")
    return value


def check_depth(value: object) -> object:
    """Reject values nested so deeply that reading or showing them could fail."""
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
    """A model without type coercion that keeps unknown members."""

    model_config = ConfigDict(strict=True, extra="allow")


class StartObject(StrictModel):
    """How the game began."""

    model_config = ConfigDict(title="Start")

    idle_frames: int = Field(
        ge=0,
        le=MAX_IDLE_FRAMES,
        description="Frames without a key after the 128 frames of the intro.",
    )
    mode: Annotated[Literal[0], BeforeValidator(reject_bool)] = Field(
        default=0, description="The cartridge's game mode."
    )
    difficulty: Annotated[Literal[0, 1], BeforeValidator(reject_bool)] = Field(
        default=0, description="The difficulty switch."
    )

    def values(self) -> dict[str, int]:
        """Return the values by name."""
        return {
            "idle_frames": self.idle_frames,
            "mode": self.mode,
            "difficulty": self.difficulty,
        }


class RecordingObject(StrictModel):
    """One recording of Tril, see exchange-format.md. Unknown members are ignored with a notice."""

    model_config = ConfigDict(title="Tril recording")

    format: Literal["tril-recording"]
    version: Annotated[Literal[1], BeforeValidator(reject_bool)]
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
    hits: list[CellArray] | None = Field(
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
    conditions: Annotated[dict[str, Any] | None, AfterValidator(check_depth)] = Field(
        default=None, description="Anything about how it was played; kept as it is."
    )
    parent: Annotated[dict[str, Any] | str | None, AfterValidator(check_depth)] = Field(
        default=None, description="The recording that this one goes on from; kept as it is."
    )
    notes: str | None = Field(
        default=None, max_length=MAX_NOTES_LENGTH, description="A person's remarks."
    )


def parse_recording(content: object) -> RecordingObject:
    """Validate an object against the schema, without replaying it.

    Raises:
        RecordingRefused: It is invalid; the message names the wrong members.
    """
    if not isinstance(content, dict):
        raise RecordingRefused(
            f"Expected one JSON object per recording, got {truncated(repr(content))}."
        )
    try:
        return RecordingObject.model_validate(normalise_json(content))
    except RecursionError:
        raise RecordingRefused("The recording is nested too deeply.") from None
    except ValidationError as error:
        raise RecordingRefused(" ".join(describe_errors(error))) from None


def recording_schema() -> dict[str, Any]:
    """Return the JSON Schema (2020-12) of a recording."""
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        **RecordingObject.model_json_schema(),
    }


def normalise_json(content: Any, keep_numbers: bool = False) -> Any:
    """Turn integral floats into ints, since JSON has one number type, and clean texts.

    Args:
        content: Parsed JSON.
        keep_numbers: Whether floats stay floats.

    Raises:
        RecordingRefused: A number is infinite, or a text can't be accepted.
    """
    match content:
        case float() if not math.isfinite(content):
            raise RecordingRefused("A number is too large.")
        case float() if content.is_integer() and not keep_numbers:
            return int(content)
        case str():
            return _cleaned(content, clean_lines)
        case dict():
            return {
                _cleaned(key, clean_line): normalise_json(
                    value, keep_numbers or key == "conditions"
                )
                for key, value in content.items()
            }
        case list():
            return [normalise_json(value, keep_numbers) for value in content]
    return content


def _cleaned(text: str, clean: Callable[[str], str]) -> str:
    try:
        return clean(text)
    except TextRefused as refusal:
        quoted = truncated(ascii(truncated(text)))
        raise RecordingRefused(f"The text {quoted} can't be accepted. {refusal}") from None


def describe_errors(error: ValidationError) -> Iterator[str]:
    """Yield one sentence for each of the first few invalid members."""
    problems = error.errors(include_url=False)
    for problem in problems[:4]:
        place = ".".join(str(part) for part in problem["loc"])
        got = truncated(repr(problem["input"]))
        if isinstance(refusal := problem.get("ctx", {}).get("error"), TextRefused):
            yield f"{place}: {refusal}"
            continue
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
                    f"start.mode: expected 0, got {got}. Alien detection is only tested in"
                    " mode 0, so other modes are not accepted."
                )
            case _:
                message = problem["msg"].replace("Input should be", "expected")
                message = message.removeprefix("Value error, ")
                yield f"{place}: {message}, got {got}."
    if len(problems) > 4:
        yield f"And {len(problems) - 4} more."


def truncated(content: object, length: int = 60) -> str:
    """Return a value's text, cut to a length in characters."""
    text = content if isinstance(content, str) else repr(content)
    return text if len(text) <= length else f"{text[: length - 1]}…"
