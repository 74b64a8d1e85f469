"""The model of a recording in the exchange format, its schema, and its error messages."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
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
    model_validator,
)

from tril.games.measures import MAX_MEASURES
from tril.recording import RecordingRefused
from tril.text import TextRefused, clean_line, clean_lines

FORMAT = "tril-recording"
VERSION = 2
MAX_NOTES_LENGTH = 4000
FIRST_YEAR, LAST_YEAR = 1970, 9998
MAX_DEPTH = 16
"""Maximum nesting of conditions and parent."""

Source = Literal["person", "scripted", "policy", "varied"]
"""Who played a recording; random: nobody, its actions were drawn at random."""

MAX_CELL = 255
"""Largest row or column of an item."""
MAX_ITEMS = 10_000

CellArray = Annotated[
    list[Annotated[int, Field(ge=0, le=MAX_CELL)]], Field(min_length=2, max_length=2)
]

MAX_GAME_NAME_LENGTH = 160
GameName = Annotated[str, Field(min_length=1, max_length=MAX_GAME_NAME_LENGTH)]
SettingsObject = Annotated[dict[str, Any], Field(max_length=8)]
MeasuresObject = Annotated[
    list[Annotated[dict[str, Any], Field(max_length=16)]], Field(max_length=MAX_MEASURES)
]


def _in_utc(moment: datetime) -> datetime:
    # Not the first and the last year, which other time zones put out of all calendars.
    if not FIRST_YEAR <= moment.year <= LAST_YEAR:
        raise ValueError(f"expected a time from {FIRST_YEAR} to {LAST_YEAR}")
    return moment.astimezone(UTC)


Moment = Annotated[AwareDatetime, AfterValidator(_in_utc)]
"""A time in UTC."""

_ACTIONS = "^(?:[A-Za-z0-9+/]{4})*(?:[A-Za-z0-9+/]{4}|[A-Za-z0-9+/]{3}=|[A-Za-z0-9+/]{2}==)$"

_RENAMED = {
    "rom_md5": "game_version",
    "ending": "end_rule",
    "hits": "taken",
    "ram_hashes": "hashes",
}
"""Members of version 1, and what they are called since."""
_START_1 = ("idle_frames", "mode", "difficulty")


def _upgraded(content: object) -> object:
    """Rename the members of version 1, which had one game; return other content as it is."""
    if not isinstance(content, dict) or content.get("version") != 1:
        return content
    if isinstance(content["version"], bool):
        return content
    renamed = {_RENAMED.get(name, name): value for name, value in content.items()}
    start = content.get("start")
    if isinstance(start, dict):
        # It ignored what it did not know of a start; the game now says what there is.
        renamed["start"] = {name: start[name] for name in _START_1 if name in start}
        renamed |= {f"start.{name}": start[name] for name in start if name not in _START_1}
    return renamed | {"version": VERSION}


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


class RecordingObject(StrictModel):
    """One recording of Tril, see exchange-format.md. Unknown members are ignored with a notice.

    Objects of version 1 are read as those of version 2.
    """

    model_config = ConfigDict(title="Tril recording")

    format: Literal["tril-recording"]
    version: Annotated[Literal[2], BeforeValidator(reject_bool)]
    game: GameName = Field(description="Name of the game, e.g. space_invaders, breakout.")
    game_version: str = Field(
        min_length=1,
        max_length=64,
        description="What a replay depends on: the MD5 of the ROM, or the package's version.",
    )
    start: dict[str, int] = Field(
        max_length=8, description="How the game began, in the game's own words."
    )
    max_steps: int | None = Field(
        default=None, ge=1, le=100_000, description="Its longest; none for the game's own length."
    )
    end_rule: str | None = Field(
        default=None,
        max_length=16,
        description="By which of the game's rules a loss ends it; none for the default.",
    )
    actions: str = Field(
        pattern=_ACTIONS,
        description="Base64 of one byte per frame: an index of the game's actions.",
    )
    taken: list[CellArray] | None = Field(
        default=None,
        max_length=MAX_ITEMS,
        description="Items taken, in order of time: [row from the bottom, column from the left],"
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
        description="How the episode ended, by the game's name for it; none where the recording"
        " ends before its episode. Compared with a replay; a difference is a notice.",
    )
    hashes: list[Annotated[str, Field(pattern="^[0-9a-f]{16}$")]] | None = Field(
        default=None,
        max_length=10_000,
        description="BLAKE2b (8 bytes, hexadecimal) of the game's memory, or of its screen where it"
        " shows none, after every second. Checked by a replay.",
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

    @model_validator(mode="before")
    @classmethod
    def _upgrade(cls, content: object) -> object:
        return _upgraded(content)


def parse_recording(content: object) -> RecordingObject:
    """Validate an object against the schema, without replaying it.

    Raises:
        RecordingRefused: It is invalid; the message names the wrong members.
    """
    if not isinstance(content, dict):
        raise RecordingRefused(
            f"Expected one JSON object per recording, got {truncated(repr(content))}."
        )
    names = (
        {new_name: old_name for old_name, new_name in _RENAMED.items()}
        if content.get("version") == 1
        else {}
    )
    try:
        return RecordingObject.model_validate(normalise_json(content))
    except RecursionError:
        raise RecordingRefused("The recording is nested too deeply.") from None
    except ValidationError as error:
        raise RecordingRefused(" ".join(describe_errors(error, names))) from None


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


def describe_errors(
    error: ValidationError, names: Mapping[str, str] | None = None
) -> Iterator[str]:
    """Yield one sentence for each of the first few invalid members.

    Args:
        error: Validation error.
        names: Names of members in the file, where they differ.
    """
    names = names or {}
    problems = error.errors(include_url=False)
    for problem in problems[:4]:
        place = ".".join(names.get(str(part), str(part)) for part in problem["loc"])
        value = truncated(repr(problem["input"]))
        if isinstance(refusal := problem.get("ctx", {}).get("error"), TextRefused):
            yield f"{place}: {refusal}"
            continue
        match problem["type"], place:
            case "missing", _:
                yield f"{place} is missing."
            case "string_pattern_mismatch", "actions":
                yield (
                    "actions: expected base64 of one byte per frame and at least one frame, got"
                    f" {value}."
                )
            case _:
                message = problem["msg"].replace("Input should be", "expected")
                message = message.removeprefix("Value error, ")
                yield f"{place}: {message}, got {value}."
    if len(problems) > 4:
        yield f"And {len(problems) - 4} more."


def truncated(content: object, length: int = 60) -> str:
    """Return a value's text, cut to a length in characters."""
    text = content if isinstance(content, str) else repr(content)
    return text if len(text) <= length else f"{text[: length - 1]}…"
