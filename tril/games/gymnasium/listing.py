"""The environments that were seen to work, for the list of games; others work by name."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path

LISTING = Path(__file__).with_name("listing.json")
"""Written by scripts.surveys.gymnasium."""


@dataclass(frozen=True)
class Listed:
    """An environment that was seen to work.

    Attributes:
        module: Module that registers the environment on import.
        requires: Modules that it needs besides.
    """

    module: str
    requires: tuple[str, ...]


@cache
def listed() -> Mapping[str, Listed]:
    """Return the environments by their ids."""
    return {
        env_id: Listed(entry["module"], tuple(entry["requires"]))
        for env_id, entry in json.loads(LISTING.read_text()).items()
    }
