"""The server's end of the process that replays."""

from __future__ import annotations

import logging
import os
import pickle
import subprocess
import sys
from collections.abc import Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import suppress

from server.play.replays.answer import Answer
from server.play.replays.request import Request, Wanted
from tril.errors import Unavailable
from tril.recording import Recording, RecordingRefused

_LOG = logging.getLogger(__name__)

_COMMAND = (sys.executable, "-m", "server.play.replays")

_UNAVAILABLE = "A recording could not be replayed; the server's log says why. Try again."


class ReplayProcess:
    """Has recordings replayed one after the other; safe to use from several threads.

    The process is started when it is first needed, and anew when it has ended.
    """

    def __init__(self) -> None:
        self._process: subprocess.Popen[bytes] | None = None
        self._thread = ThreadPoolExecutor(1, thread_name_prefix="replays")

    def prepare(self) -> None:
        """Start the process if it does not run, without waiting for it."""
        self._thread.submit(self._running)

    def submit(
        self, wanted: Wanted, recording: Recording, hits: Sequence[tuple[int, int]] = ()
    ) -> Future[bytes]:
        """Ask for a replay.

        Args:
            wanted: What it is for.
            recording: What to replay.
            hits: For a check, the (row, column) that it is said to hit, in order of time.

        Returns:
            What is wanted, nothing for a check; or RecordingRefused, where the recording does not
            replay, or Unavailable.
        """
        return self._thread.submit(self._answer, Request(wanted, recording, tuple(hits)))

    def stop(self) -> None:
        """End the process once it has answered what was asked for."""
        self._thread.shutdown()
        self._end()

    def _answer(self, request: Request) -> bytes:
        answer = self._ask(request)
        if answer.refusal is not None:
            raise RecordingRefused(answer.refusal)
        if answer.failure is not None:
            _LOG.error("A replay failed: %s", answer.failure)
            raise Unavailable(_UNAVAILABLE)
        return answer.content

    def _ask(self, request: Request) -> Answer:
        """Ask the process; one that has ended meanwhile is asked anew, once."""
        for is_last in (False, True):
            try:
                process = self._running()
                assert process.stdin is not None
                assert process.stdout is not None
                pickle.dump(request, process.stdin)
                process.stdin.flush()
                answer: Answer = pickle.load(process.stdout)
            except (OSError, EOFError, pickle.UnpicklingError) as error:
                self._end()
                _LOG.warning("The process that replays recordings has ended: %r", error)
                if is_last:
                    raise Unavailable(_UNAVAILABLE) from error
            else:
                return answer
        raise AssertionError("unreachable")

    def _running(self) -> subprocess.Popen[bytes]:
        if self._process is None or self._process.poll() is not None:
            self._end()
            self._process = subprocess.Popen(
                _COMMAND,
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                # As many threads as cores would take them from those who play.
                env=os.environ | {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"},
            )
        return self._process

    def _end(self) -> None:
        process, self._process = self._process, None
        if process is None:
            return
        for end in (process.stdin, process.stdout):
            assert end is not None
            with suppress(OSError):
                end.close()
        process.kill()
        process.wait()
