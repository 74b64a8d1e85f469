"""One process that replays recordings, for all servers of a test process."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

import pytest

from server import services
from server.play.replays import ReplayProcess
from tril.recording import Recording


class SharedReplays(ReplayProcess):
    """One process for all servers: each would take a second to start its own."""

    def serving(self, keep_strip: Callable[[Recording, bytes], None]) -> SharedReplays:
        """Serve another server from now on."""
        self._keep_strip = keep_strip
        return self

    def stop(self) -> None:
        """Leave it to the servers that follow."""

    def end(self) -> None:
        """Stop it."""
        super().stop()


@contextmanager
def shared_replays() -> Iterator[None]:
    """Let the servers that are made in a block share a process."""
    shared = SharedReplays()
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(services, "ReplayProcess", shared.serving)
        yield
    shared.end()
