"""Verification of played games by replay."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Callable

from server.play.replays import ReplayProcess, ReplayTask
from tril.errors import Unavailable
from tril.game.episode import Hit
from tril.recording import Recording, RecordingRefused

_LOG = logging.getLogger(__name__)

RETRY_S = 1.0


async def find_refusal(
    replays: ReplayProcess,
    recording: Recording,
    hits: tuple[Hit, ...],
    give_up: Callable[[], bool],
) -> str | None:
    """Replay a recording; returns how the replay differs from the game, None if it does not.

    Args:
        replays: The replay process.
        recording: What was played.
        hits: What it hit.
        give_up: Asked after each failure to replay whether to raise instead of retrying.

    Raises:
        Unavailable: The recording could not be replayed.
    """
    cells = [(hit.row, hit.column) for hit in hits]
    while True:
        try:
            await asyncio.wrap_future(replays.submit(ReplayTask.CHECK, recording, cells))
        except RecordingRefused as error:
            _LOG.error("A game does not replay: %s", error)
            return str(error)
        except Unavailable:
            if give_up():
                raise
            await asyncio.sleep(RETRY_S)
        else:
            return None
