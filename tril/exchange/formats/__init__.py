"""File formats: one recording as a JSON object, many as JSON Lines, a whole behaviour.

See docs/exchange-format.md and docs/behaviour-format.md. ``python -m tril.exchange`` prints their
JSON Schemas, which are generated from the models in recording_object.py and behaviour_file.py.
"""

from tril.exchange.formats.behaviour_file import (
    BEHAVIOUR_FORMAT,
    BEHAVIOUR_VERSION,
    BehaviourObject,
    BehaviourRefused,
    NumberedRecording,
    behaviour_schema,
    parse_behaviour,
)
from tril.exchange.formats.jsonl import MAX_OBJECT_BYTES, MAX_OBJECTS, Line, read_lines
from tril.exchange.formats.recording_file import Exchanged, from_exchange, ranked, to_exchange
from tril.exchange.formats.recording_object import (
    FORMAT,
    MAX_NOTES_LENGTH,
    VERSION,
    Source,
    parse,
    schema,
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
    "Exchanged",
    "Line",
    "NumberedRecording",
    "Source",
    "behaviour_schema",
    "from_exchange",
    "parse",
    "parse_behaviour",
    "ranked",
    "read_lines",
    "schema",
    "to_exchange",
]
