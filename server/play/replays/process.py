"""The server's end of the replay process."""

from __future__ import annotations

import logging
import os
import pickle
import subprocess
import sys
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import suppress
from pathlib import Path

from server.play.replays.request import (
    Answer,
    AnyRequest,
    Content,
    LoadRequest,
    MeasureRequest,
    ReplayTask,
    Request,
    UnderstandRequest,
    Understood,
    VariedPlayRequest,
    WatchRequest,
)
from tril.errors import Unavailable
from tril.exchange.formats.recording_file import ImportedRecording
from tril.games import UnknownGame
from tril.games.base import Cell
from tril.games.measures import Measure
from tril.games.measuring import Values
from tril.recording import Recording, RecordingRefused, Verified

_LOG = logging.getLogger(__name__)

_COMMAND = (sys.executable, "-m", "server.play.replays")

_UNAVAILABLE = "A recording could not be replayed; the server's log says why. Try again."


class ReplayProcess:
    """Replays recordings and makes games of varied play in a child process, in turn; thread-safe.

    The process is started when it is first needed, and restarted when it has died.

    Args:
        keep_strip: Called in a thread with each recording that passes its check and its film
            strip.
    """

    def __init__(self, keep_strip: Callable[[Recording, bytes], None] = lambda *_: None) -> None:
        self._keep_strip = keep_strip
        self._process: subprocess.Popen[bytes] | None = None
        self._thread = ThreadPoolExecutor(1, thread_name_prefix="replays")

    def prepare(self) -> None:
        """Start the process in the background unless it runs."""
        self._thread.submit(self._running).add_done_callback(_log_failure)

    def submit(
        self, task: ReplayTask, recording: Recording, taken: Sequence[Cell] = ()
    ) -> Future[bytes]:
        """Request a replay.

        Args:
            task: Task of the replay.
            recording: The recording.
            taken: For a check, the items that it is said to take, in order of time.

        Returns:
            The product, empty for a check; or RecordingRefused, if the replay differs from what was
            recorded, UnknownGame, if the process does not have its game, or Unavailable.
        """
        return self._thread.submit(self._execute, Request(task, recording, tuple(taken)))

    def play_varied(self, game: str, seed: int) -> Future[Verified]:
        """Request a game of varied play, which takes half a second to two seconds.

        Submit one at a time, so that the check of a game that ends waits for one at most.

        Args:
            game: Name of the game.
            seed: Seed of all that is drawn for it.
        """
        return self._thread.submit(self._play, VariedPlayRequest(game, seed))

    def load(self, content: object) -> ImportedRecording:
        """Load a recording from the exchange format and verify it, in turn with other replays.

        Args:
            content: Parsed JSON.

        Raises:
            RecordingRefused: See ``load_recording``.
            Unavailable: It could not be replayed.
        """
        return self._thread.submit(self._load, LoadRequest(content)).result()

    def measure(self, recording: Recording, measures: Sequence[Measure]) -> Values:
        """Measure a recording in a replay, in turn with others.

        Args:
            recording: The recording.
            measures: Measures to take; the game has them.

        Raises:
            RecordingRefused: The replay differs from what was recorded.
            Unavailable: It could not be replayed.
        """
        request = MeasureRequest(recording, tuple(measures))
        return self._thread.submit(self._measure, request).result()

    def watch(self, recording: Recording, vocabulary: Path) -> bytes:
        """Return what a vocabulary sees of a recording in a replay, in turn with others.

        See `tril.vocabulary.watched.Watched.pack`.

        Args:
            recording: The recording.
            vocabulary: File of its game's vocabulary.

        Raises:
            RecordingRefused: It was played on another version of the game, or the replay differs.
            Unavailable: It could not be replayed.
        """
        return self._thread.submit(self._watch, WatchRequest(recording, vocabulary)).result()

    def understand(self, request: UnderstandRequest) -> Understood:
        """Infer what an order is about, which takes a fifth of a second.

        Raises:
            Unavailable: It could not be inferred.
        """
        return self._thread.submit(self._understand, request).result()

    def stop(self) -> None:
        """Stop the process after the requests that were submitted."""
        self._thread.shutdown()
        self._end()

    def _execute(self, request: Request) -> bytes:
        content = self._content(request)
        assert isinstance(content, bytes)
        if request.task is ReplayTask.CHECK:
            self._keep_strip(request.recording, content)
            return b""
        return content

    def _play(self, request: VariedPlayRequest) -> Verified:
        content = self._content(request)
        assert isinstance(content, Verified)
        return content

    def _load(self, request: LoadRequest) -> ImportedRecording:
        content = self._content(request)
        assert isinstance(content, ImportedRecording)
        return content

    def _measure(self, request: MeasureRequest) -> Values:
        content = self._content(request)
        assert isinstance(content, Mapping)
        return content

    def _watch(self, request: WatchRequest) -> bytes:
        content = self._content(request)
        assert isinstance(content, bytes)
        return content

    def _understand(self, request: UnderstandRequest) -> Understood:
        content = self._content(request)
        assert isinstance(content, Understood)
        return content

    def _content(self, request: AnyRequest) -> Content:
        answer = self._ask(request)
        if answer.refusal is not None:
            raise RecordingRefused(answer.refusal)
        if answer.unknown_game is not None:
            raise UnknownGame(answer.unknown_game)
        if answer.failure is not None:
            _LOG.error("A replay failed: %s", answer.failure)
            raise Unavailable(_UNAVAILABLE)
        return answer.content

    def _ask(self, request: AnyRequest) -> Answer:
        """Send a request; retries once with a new process if the present one has died."""
        packed = pickle.dumps(request)
        for is_last in (False, True):
            try:
                process = self._running()
                assert process.stdin is not None
                assert process.stdout is not None
                pickle.dump(packed, process.stdin)
                process.stdin.flush()
                answered: bytes = pickle.load(process.stdout)
            except (OSError, EOFError, pickle.UnpicklingError) as error:
                self._end()
                _LOG.warning("The replay process has died: %r", error)
                if is_last:
                    raise Unavailable(_UNAVAILABLE) from error
            else:
                answer: Answer = pickle.loads(answered)
                return answer
        raise AssertionError("unreachable")

    def _running(self) -> subprocess.Popen[bytes]:
        if self._process is None or self._process.poll() is not None:
            self._end()
            self._process = subprocess.Popen(
                _COMMAND,
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                # One thread per core would slow down the games being played.
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


def _log_failure(started: Future[subprocess.Popen[bytes]]) -> None:
    if not started.cancelled() and (error := started.exception()) is not None:
        _LOG.error("The replay process could not be started.", exc_info=error)
