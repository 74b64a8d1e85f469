"""What the tests of policies share: their games are played in the tests' own process."""

from __future__ import annotations

from collections.abc import Iterator

import pytest


@pytest.fixture(scope="module", autouse=True)
def _one_process() -> Iterator[None]:
    """Let games have one core: a process takes longer to start than these games to play.

    That their number changes nothing, tests/tril/play/vector holds.
    """
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("tril.play.vector.vector_game.core_count", lambda: 1)
        yield
