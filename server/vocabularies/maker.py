"""Runs the process that makes vocabularies, one at a time, in the background."""

from __future__ import annotations

import logging
import os
import pickle
import subprocess
import sys
import tempfile
import threading
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

from server.turns import ONE_THREAD
from tril.errors import Invalid, NotFound
from tril.games.base import Game
from tril.vocabulary.facts import Vocabulary
from tril.vocabulary.making import pictures_path, vocabulary_key, vocabulary_path
from tril.vocabulary.pictures import pictured_kinds, read_picture

_LOG = logging.getLogger(__name__)

_COMMAND = (sys.executable, "-m", "server.vocabularies")
_LOG_TAIL_BYTES = 4_000


@lru_cache(maxsize=4)
def _load(path: Path, _changed_ns: int) -> Vocabulary:
    """Read a vocabulary, which takes tens of milliseconds, once for each change of its file."""
    return Vocabulary.load(path)


@dataclass(frozen=True)
class Making:
    """How far the making of a vocabulary is.

    Attributes:
        path: File of the vocabulary, once made; pictures of the things may come later.
        progress: Share of what is done, 0 to 1.
        failed: Whether making it failed; the server's log says why.
    """

    path: Path | None = None
    progress: float = 0.0
    failed: bool = False


class VocabularyMaker:
    """Makes vocabularies in a child process that ends with this one; thread-safe.

    One that failed is not tried again before the server's next start, but used if another process
    has made it.

    Args:
        data: The data folder.
    """

    def __init__(self, data: Path) -> None:
        self._data = data
        self._lock = threading.Lock()
        self._makings: dict[str, Making] = {}
        self._process: subprocess.Popen[bytes] | None = None
        self._stopping = False
        self._thread = ThreadPoolExecutor(1, thread_name_prefix="vocabularies")

    def vocabulary(self, game: Game) -> Making:
        """Return the progress of a game's vocabulary, and have it made unless it exists."""
        key = vocabulary_key(game)
        with self._lock:
            making = self._makings.get(key)
            if making and making.failed and (found := self._look(game)).path:
                # A worker has made it meanwhile.
                making = self._makings[key] = found
            if making is None:
                making = self._look(game)
                self._makings[key] = making
                if making.path is None or not pictures_path(self._data, game).exists():
                    self._thread.submit(self._make, key, game)
        return making

    def known(self, game: Game) -> Vocabulary | None:
        """Return a game's vocabulary if it is made already; none is made for it."""
        path = vocabulary_path(self._data, game)
        try:
            return _load(path, path.stat().st_mtime_ns)
        except (OSError, Invalid):
            return None

    def pictured(self, game: Game) -> frozenset[int]:
        """Return the kinds of things that there are pictures of, by their indices."""
        return pictured_kinds(pictures_path(self._data, game))

    def picture(self, game: Game, kind: int) -> bytes:
        """Return the PNG of a kind of things, by its index in the game's vocabulary.

        Raises:
            NotFound: There is none (yet).
        """
        picture = read_picture(pictures_path(self._data, game), kind)
        if picture is None:
            raise NotFound("There is no picture of this thing.")
        return picture

    def stop(self) -> None:
        """End the process and give up what waits."""
        with self._lock:
            self._stopping = True
            if self._process is not None:
                self._process.kill()
        self._thread.shutdown(cancel_futures=True)

    def _look(self, game: Game) -> Making:
        path = vocabulary_path(self._data, game)
        try:
            Vocabulary.load(path)
        except Invalid:
            return Making()
        return Making(path, 1.0)

    def _make(self, key: str, game: Game) -> None:
        try:
            self._run(key, game)
        except (OSError, ValueError, pickle.PicklingError):
            _LOG.exception("The vocabulary of %s could not be made.", game.title)
        making = self._look(game)
        self._makings[key] = making if making.path else Making(failed=True)

    def _run(self, key: str, game: Game) -> None:
        with tempfile.TemporaryFile() as errors:
            with self._lock:
                if self._stopping:
                    return
                process = self._process = subprocess.Popen(
                    _COMMAND,
                    stdin=subprocess.PIPE,
                    stdout=subprocess.PIPE,
                    stderr=errors,
                    env=os.environ | ONE_THREAD,
                )
            assert process.stdin is not None
            assert process.stdout is not None
            # One that failed at once reads nothing.
            with suppress(BrokenPipeError), process.stdin, process.stdout:
                pickle.dump((self._data, game), process.stdin)
                process.stdin.flush()
                for line in process.stdout:
                    if self._makings[key].path is None:
                        self._makings[key] = Making(progress=float(line))
            status = process.wait()
            if status != 0 and not self._stopping:
                errors.seek(max(errors.seek(0, os.SEEK_END) - _LOG_TAIL_BYTES, 0))
                log = errors.read().decode(errors="replace")
                _LOG.error("The vocabulary of %s could not be made: %s", game.title, log)
