"""File formats: one recording as a JSON object, many as JSON Lines, a whole behaviour.

See docs/exchange-format.md and docs/behaviour-format.md. ``python -m tril.exchange`` prints their
JSON Schemas.
"""

from tril.exchange.formats.behaviour_file import (
    BEHAVIOUR_FORMAT,
    BEHAVIOUR_VERSION,
    BehaviourObject,
    BehaviourRefused,
    NumberedRecording,
    RevisionObject,
    behaviour_schema,
    parse_behaviour,
)
from tril.exchange.formats.jsonl import MAX_OBJECT_BYTES, MAX_OBJECTS, JsonLine, read_lines
from tril.exchange.formats.recording_file import (
    ImportedRecording,
    dump_recording,
    load_recording,
    ranking_of,
)
from tril.exchange.formats.recording_object import (
    FORMAT,
    MAX_NOTES_LENGTH,
    VERSION,
    Source,
    parse_recording,
    recording_schema,
)

__all__ = [
    "BEHAVIOUR_FORMAT",
    "BEHAVIOUR_VERSION",
    "FORMAT",
    "MAX_NOTES_LENGTH",
    "MAX_OBJECTS",
    "MAX_OBJECT_BYTES",
    "VERSION",
    "BehaviourObject",
    "BehaviourRefused",
    "ImportedRecording",
    "JsonLine",
    "NumberedRecording",
    "RevisionObject",
    "Source",
    "behaviour_schema",
    "dump_recording",
    "load_recording",
    "parse_behaviour",
    "parse_recording",
    "ranking_of",
    "read_lines",
    "recording_schema",
]
