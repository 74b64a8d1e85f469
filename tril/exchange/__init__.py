"""The exchange format: one recording as one JSON object, many as JSON Lines.

docs/exchange-format.md explains it. docs/exchange-format.schema.json is generated from the model
in objects.py by ``python -m tril.exchange``.
"""

from tril.exchange.lines import MAX_OBJECT_BYTES, MAX_OBJECTS, Line, read_lines
from tril.exchange.objects import FORMAT, MAX_NOTES_LENGTH, VERSION, Source, parse, schema
from tril.exchange.recordings import Exchanged, from_exchange, ranked, to_exchange

__all__ = [
    "FORMAT",
    "MAX_NOTES_LENGTH",
    "MAX_OBJECTS",
    "MAX_OBJECT_BYTES",
    "VERSION",
    "Exchanged",
    "Line",
    "Source",
    "from_exchange",
    "parse",
    "ranked",
    "read_lines",
    "schema",
    "to_exchange",
]
