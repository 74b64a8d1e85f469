"""The model of a behaviour file: the behaviour, its recordings, every revision of the ranking.

See docs/behaviour-format.md. ``python -m scripts.schemas behaviour`` generates
docs/behaviour-format.schema.json from it.
"""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Iterator
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, ConfigDict, Field, ValidationError

from tril.errors import Invalid
from tril.exchange.formats.json_text import decode_json, describe_foreign, parse_json
from tril.exchange.formats.recording_object import (
    MAX_ITEMS,
    CellArray,
    GameName,
    MeasuresObject,
    Moment,
    RecordingObject,
    SettingsObject,
    StrictModel,
    describe_errors,
    normalise_json,
    reject_bool,
    truncated,
)
from tril.games.base import MAX_FRAMES
from tril.recording import RecordingRefused
from tril.text import Line
from tril.vocabulary.answers import MOST_SUBJECTS

BEHAVIOUR_FORMAT = "tril-behaviour"
BEHAVIOUR_VERSION = 2

MAX_RECORDINGS = 10_000
MAX_REVISIONS = 100_000
MAX_ANSWERS = 1_000

_Number = Annotated[int, Field(ge=1, le=2**31 - 1)]
_Time = Annotated[Moment, Field(strict=False)]


class BehaviourRefused(Invalid):
    """A file that is not a valid behaviour file."""


class _ClosedModel(StrictModel):
    model_config = ConfigDict(strict=True, extra="forbid")


class ParentObject(_ClosedModel):
    """The recording that another goes on from."""

    model_config = ConfigDict(title="Parent")

    number: _Number = Field(description="Its number in this file.")
    frame: int = Field(ge=0, le=MAX_FRAMES, description="The last frame that both share.")


class NumberedRecording(_ClosedModel):
    """A recording in the library of a behaviour."""

    model_config = ConfigDict(title="Numbered recording")

    number: _Number = Field(description="By which rankings and others in this file name it.")
    recording: RecordingObject = Field(
        description="In the exchange format of recordings; tier and parent have no meaning here."
    )
    player: Line | None = Field(
        default=None, min_length=1, max_length=80, description="Who played."
    )
    played_at: _Time
    unfinished: bool = Field(default=False, description="Whether its game was abandoned.")
    deleted: bool = Field(
        default=False, description="Whether it was deleted; earlier revisions may still name it."
    )
    parent: ParentObject | None = None


class RevisionObject(_ClosedModel):
    """One revision of the ranking, as it was saved."""

    model_config = ConfigDict(title="Revision")

    revision: _Number
    tiers: list[Annotated[list[_Number], Field(min_length=1)]] = Field(
        description="Numbers of recordings, best tier first."
    )
    change: Literal["edit", "undo", "redo", "import", "deletion", "example"]
    player: Line | None = Field(default=None, min_length=1, max_length=80)
    saved_at: _Time
    undo_to: int | None = Field(default=None, ge=0, description="What an undo brings back.")
    redo_to: int | None = Field(default=None, ge=1, description="What a redo brings back.")


class AnswerObject(_ClosedModel):
    """What a person said of a statement that Tril made about the ranking."""

    model_config = ConfigDict(title="Answer")

    subjects: list[Annotated[Line, Field(min_length=1, max_length=120)]] = Field(
        min_length=1, max_length=MOST_SUBJECTS, description="What the statement is about."
    )
    sentence: Line = Field(min_length=1, max_length=400, description="What they read.")
    meant: bool = Field(description="Whether it is what they mean.")
    player: Line | None = Field(default=None, min_length=1, max_length=80)
    answered_at: _Time


class BehaviourObject(_ClosedModel):
    """One behaviour of Tril with all that was played and ranked of it, see behaviour-format.md."""

    model_config = ConfigDict(title="Tril behaviour")

    format: Literal["tril-behaviour"]
    version: Annotated[Literal[1, 2], BeforeValidator(reject_bool)]
    game: GameName
    settings: SettingsObject = Field(default={}, description="What the behaviour sets of its game.")
    measures: MeasuresObject = Field(
        default=[], description="What of a game tells in numbers how well it shows the behaviour."
    )
    slug: str = Field(min_length=1, max_length=80, pattern="^[a-z0-9-]+$")
    name: Line = Field(min_length=1, max_length=120)
    description: str = Field(default="", max_length=2000)
    target: list[CellArray] | None = Field(
        default=None,
        min_length=1,
        max_length=MAX_ITEMS,
        description="Items to take: [row from the bottom, column from the left], from 0; null"
        " where items do not describe the behaviour.",
    )
    ordered: bool = Field(default=False, description="Whether they have to be taken in this order.")
    recordings: list[NumberedRecording] = Field(max_length=MAX_RECORDINGS)
    rankings: list[RevisionObject] = Field(
        max_length=MAX_REVISIONS, description="Every revision, from 1 on; the last is in force."
    )
    answers: list[AnswerObject] = Field(
        default=[], max_length=MAX_ANSWERS, description="The latest one of each statement."
    )


def behaviour_schema() -> dict[str, Any]:
    """Return the JSON Schema (2020-12) of a behaviour file."""
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        **BehaviourObject.model_json_schema(),
    }


def parse_behaviour(content: bytes) -> BehaviourObject:
    """Parse and validate a behaviour file without replaying its recordings.

    Raises:
        BehaviourRefused: It is not a behaviour file, of a newer version, or inconsistent.
    """
    data = _object(content)
    try:
        behaviour = BehaviourObject.model_validate(normalise_json(data))
    except RecursionError:
        raise BehaviourRefused("The file is nested too deeply.") from None
    except ValidationError as error:
        raise BehaviourRefused(" ".join(describe_errors(error))) from None
    except RecordingRefused as error:
        raise BehaviourRefused(str(error)) from None
    contradictions = list(_contradictions(behaviour))
    if contradictions:
        remainder = f" And {len(contradictions) - 4} more." if len(contradictions) > 4 else ""
        raise BehaviourRefused(" ".join(contradictions[:4]) + remainder)
    return behaviour


def _object(content: bytes) -> dict[str, Any]:
    """Return the object in a file; refuse other formats and newer versions."""
    if (foreign := describe_foreign(content, BEHAVIOUR_FORMAT)) is not None:
        raise BehaviourRefused(
            f"The file is {foreign}. Expected a file of `tril behaviours export`."
        )
    try:
        data = parse_json(decode_json(content))
    except json.JSONDecodeError as error:
        raise BehaviourRefused(
            f"The file was not written by `tril behaviours export`: it is not JSON ({error})."
        ) from None
    except ValueError as error:
        raise BehaviourRefused(f"The file can't be read: {error}.") from None
    if not isinstance(data, dict) or data.get("format") != BEHAVIOUR_FORMAT:
        file_format = data.get("format") if isinstance(data, dict) else data
        raise BehaviourRefused(
            "The file was not written by `tril behaviours export`: expected the format"
            f" {BEHAVIOUR_FORMAT!r}, got {truncated(repr(file_format))}."
        )
    version = data.get("version")
    if isinstance(version, int) and version > BEHAVIOUR_VERSION:
        raise BehaviourRefused(
            f"The file was written by a newer version of Tril (format version {version}; this"
            f" version reads {BEHAVIOUR_VERSION}). Update Tril."
        )
    return data


def _contradictions(behaviour: BehaviourObject) -> Iterator[str]:
    by_number = {played.number: played for played in behaviour.recordings}
    twice = Counter(played.number for played in behaviour.recordings)
    for number, times in twice.items():
        if times > 1:
            yield f"{times} recordings have the number {number}."
    for played in behaviour.recordings:
        parent = played.parent
        if parent is not None and (
            parent.number not in by_number or parent.number == played.number
        ):
            yield (
                f"Recording {played.number} goes on from {parent.number}, which is"
                f" {'itself' if parent.number == played.number else 'not in the file'}."
            )
    for place, saved in enumerate(behaviour.rankings, start=1):
        yield from _revision_errors(place, saved, set(by_number))
    if behaviour.rankings:
        for ranked in (number for tier in behaviour.rankings[-1].tiers for number in tier):
            played_game = by_number.get(ranked)
            if played_game is not None and (played_game.deleted or played_game.unfinished):
                yield (
                    f"The last revision ranks recording {ranked}, which is"
                    f" {'deleted' if played_game.deleted else 'unfinished'}."
                )


def _revision_errors(place: int, saved: RevisionObject, numbers: set[int]) -> Iterator[str]:
    if saved.revision != place:
        yield f"Expected revision {place} of the ranking, got {saved.revision}."
        return
    ranked = [number for tier in saved.tiers for number in tier]
    if missing := sorted(set(ranked) - numbers):
        names = ", ".join(map(str, missing[:10]))
        yield f"Revision {place} ranks recordings that are not in the file: {names}."
    if twice := sorted(number for number, times in Counter(ranked).items() if times > 1):
        yield f"Revision {place} ranks a recording twice: {', '.join(map(str, twice[:10]))}."
    for field, revision in (("undo_to", saved.undo_to), ("redo_to", saved.redo_to)):
        if revision is not None and revision >= place:
            yield f"{field} of revision {place} is {revision}; expected an earlier revision."
