"""The example games of docs/examples, as if a package with them were installed."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path

import pytest

import tril.games

FOLDER = Path(__file__).parents[3] / "docs" / "examples"


@contextmanager
def examples_installed() -> Iterator[None]:
    """Install the example games for a while."""

    def with_catch(**selection: str) -> list[EntryPoint]:
        catch = EntryPoint("catch", "catch_game:CATCH", tril.games.GROUP)
        return [*entry_points(group=selection["group"]), catch]

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("tril.games.entry_points", with_catch)
        patch.syspath_prepend(FOLDER)
        _forget()
        __import__("catch_env")
        yield
    _forget()


def _forget() -> None:
    tril.games._sources.cache_clear()
    tril.games.game_named.cache_clear()
    for name in ("catch_env", "catch_game"):
        sys.modules.pop(name, None)
