"""Print the JSON Schema of a recording in the exchange format or of a behaviour file."""

import json
import sys

from tril.exchange.formats.behaviour_file import behaviour_schema
from tril.exchange.formats.recording_object import recording_schema

SCHEMAS = {"recording": recording_schema, "behaviour": behaviour_schema}

if __name__ == "__main__":
    schema = sys.argv[1] if len(sys.argv) > 1 else "recording"
    if schema not in SCHEMAS:
        sys.exit(f"Expected one of {', '.join(SCHEMAS)}, got {schema!r}.")
    json.dump(SCHEMAS[schema](), sys.stdout, indent=2)
    sys.stdout.write("\n")
