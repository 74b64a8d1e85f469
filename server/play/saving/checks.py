"""Checks that games replay to what was played, before they count."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Callable

from server.play.replays import ReplayProcess, Wanted
from tril.errors import Unavailable
from tril.game.episode import Hit
from tril.recording import Recording, RecordingRefused

_LOG = logging.getLogger(__name__)

RETRY_S = 1.0


class Checks:
    """Has games replayed.

    Args:
        replays: What replays them.
    """

    def __init__(self, replays: ReplayProcess) -> None:
        self._replays = replays

    def prepare(self) -> None:
        """Make ready for the end of a game that begins now."""
        self._replays.prepare()

    async def refusal(
        self, recording: Recording, hits: tuple[Hit, ...], gives_up: Callable[[], bool]
    ) -> str | None:
        """Replay a recording; returns why it is not what was played, None if it is.

        Args:
            recording: What was played.
            hits: What it hit.
            gives_up: Asked whenever replaying failed; otherwise it is tried again.

        Raises:
            Unavailable: It was given up.
        """
        cells = [(hit.row, hit.column) for hit in hits]
        while True:
            try:
                await asyncio.wrap_future(self._replays.submit(Wanted.CHECK, recording, cells))
            except RecordingRefused as error:
                _LOG.error("A game does not replay: %s", error)
                return str(error)
            except Unavailable:
                if gives_up():
                    raise
                await asyncio.sleep(RETRY_S)
            else:
                return None
