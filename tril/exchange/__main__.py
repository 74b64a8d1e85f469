"""Print the JSON Schema of the exchange format."""

import json
import sys

from tril.exchange.objects import schema

json.dump(schema(), sys.stdout, indent=2)
sys.stdout.write("\n")
