"""Logging of the worker and the inference process."""

from __future__ import annotations

import logging
import sys

from tril.logs import PlainFormatter


def set_up_logging() -> None:
    """Log to the standard output; of libraries, warnings only."""
    handler = logging.StreamHandler(sys.stdout)
    handler.setFormatter(PlainFormatter("%(asctime)s %(message)s"))
    logging.basicConfig(level=logging.INFO, handlers=[handler], force=True)
    logging.getLogger("alembic").setLevel(logging.WARNING)
