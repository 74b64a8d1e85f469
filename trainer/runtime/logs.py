"""What trainer processes say on their output."""

from __future__ import annotations

import logging
import sys


def set_up_logging() -> None:
    """Write this project's lines to the output, and of libraries only what is wrong."""
    logging.basicConfig(
        level=logging.INFO, stream=sys.stdout, format="%(asctime)s %(message)s", force=True
    )
    logging.getLogger("alembic").setLevel(logging.WARNING)
