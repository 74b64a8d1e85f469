"""Logging of the worker and the inference process."""

from __future__ import annotations

import logging
import sys


def set_up_logging() -> None:
    """Log to the standard output; of libraries, warnings only."""
    logging.basicConfig(
        level=logging.INFO, stream=sys.stdout, format="%(asctime)s %(message)s", force=True
    )
    logging.getLogger("alembic").setLevel(logging.WARNING)
