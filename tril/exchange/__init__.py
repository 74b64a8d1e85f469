"""The exchange format: one recording as one JSON object, many as JSON Lines; whole behaviours.

docs/exchange-format.md explains it. docs/exchange-format.schema.json is generated from the model
in objects.py by ``python -m tril.exchange``. For a behaviour's file it is docs/behaviour-format.md
and behaviours.py.
"""

from tril.exchange.behaviours import (
    BEHAVIOUR_FORMAT,
    BEHAVIOUR_VERSION,
    BehaviourObject,
    BehaviourRefused,
    NumberedRecording,
    behaviour_schema,
    parse_behaviour,
)
from tril.exchange.lines import MAX_OBJECT_BYTES, MAX_OBJECTS, Line, read_lines
from tril.exchange.objects import FORMAT, MAX_NOTES_LENGTH, VERSION, Source, parse, schema
from tril.exchange.recordings import Exchanged, from_exchange, ranked, to_exchange

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
