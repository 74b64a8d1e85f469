"""Runs the process that makes clips, one clip at a time."""

from __future__ import annotations

import logging
import sys

from server.clips.request import ClipKind, write_request
from server.turns import Turns, run_program
from tril.errors import Invalid, Unavailable
from tril.recording import Recording

_LOG = logging.getLogger(__name__)

REFUSED = 3
"""Exit status if the recording does not replay; standard error says why."""

TIMEOUT_S = 120.0
"""A full game takes about 3 s on an idle core."""
MAX_WAITING = 4
"""One person has at most four requests under way (Services.replay_limit), so that one is left."""


class ClipMaker:
    """Makes one clip at a time; thread-safe.

    Args:
        timeout_s: Timeout of a clip.
        max_waiting: Most waiting requests; further ones are refused.
    """

    def __init__(self, timeout_s: float = TIMEOUT_S, max_waiting: int = MAX_WAITING) -> None:
        self._timeout_s = timeout_s
        self._turns = Turns("clips", max_waiting)

    def make(self, recording: Recording, kind: ClipKind) -> bytes:
        """Return a recording as a file of this kind.

        Raises:
            Unavailable: Too many requests wait, or this one failed or took too long.
            Invalid: The recording does not replay.
        """
        with self._turns.turn():
            return self._run(write_request(recording, kind))

    def _run(self, request: bytes) -> bytes:
        command = [sys.executable, "-m", "server.clips"]
        result = run_program(command, self._timeout_s, "clip", request)
        if result.returncode == REFUSED:
            raise Invalid(result.stderr.decode(errors="replace"))
        if result.returncode != 0 or not result.stdout:
            _LOG.error("A clip could not be made: %s", result.stderr.decode(errors="replace"))
            raise Unavailable("The clip could not be made; the server's log says why.")
        return result.stdout
