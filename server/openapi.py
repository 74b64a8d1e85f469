"""Print the OpenAPI document: ``python -m server.openapi > frontend/openapi.json``."""

from __future__ import annotations

import json
import sys

from server.app import create_app
from tril.settings import Settings

if __name__ == "__main__":
    # Nothing of this machine's settings reaches the document.
    json.dump(create_app(Settings.model_construct()).openapi(), sys.stdout, indent=2)
    sys.stdout.write("\n")
