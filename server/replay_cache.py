"""Files derived from recordings by replay, cached on disk."""

from __future__ import annotations

import hashlib
import threading
from pathlib import Path

from server.clips import ClipKind, ClipMaker
from server.play.replays import ReplayProcess, ReplayTask
from tril.files.cache import Cache
from tril.recording import Recording
from tril.vocabulary.watched import Watched

_FORMAT = 2
"""Raised whenever the files change, so that cached ones of an earlier version are not used."""


def version_of(recording: Recording) -> str:
    """Return a short digest of everything that a replay depends on."""
    game = recording.game
    digest = hashlib.blake2b(recording.actions, digest_size=10)
    version = (
        _FORMAT,
        game.name,
        recording.version,
        recording.start.key,
        recording.end_rule,
        game.screen.hidden,
    )
    digest.update(repr(version).encode())
    return digest.hexdigest()


def keep_strip(cache: Cache, recording: Recording, strip: bytes) -> None:
    """Keep a film strip that was made while the recording was checked."""
    cache.get(_name(recording, ReplayTask.STRIP), lambda: strip)


class ReplayCache:
    """Frames, film strips, memory, observations, things, facts and clips; thread-safe.

    Args:
        cache: Where the files are kept.
        replays: The process that replays recordings.
        clips: Makes clips.
    """

    def __init__(
        self, cache: Cache, replays: ReplayProcess, clips: ClipMaker | None = None
    ) -> None:
        self._cache = cache
        self._replays = replays
        self._clips = clips or ClipMaker()
        # One at a time, so that the check of a game that ends waits for one at most.
        self._lock = threading.Lock()

    def get(self, recording: Recording, task: ReplayTask) -> bytes:
        """Return a product of a replay, replaying the recording unless the file is cached."""

        def replay() -> bytes:
            with self._lock:
                return self._replays.submit(task, recording).result()

        return self._cache.get(_name(recording, task), replay)

    def watched(self, recording: Recording, vocabulary: Path) -> Watched:
        """Return what a vocabulary sees of a recording, replaying it unless that is cached.

        Args:
            recording: The recording.
            vocabulary: File of its game's vocabulary, named by what it depends on.
        """

        def replay() -> bytes:
            with self._lock:
                return self._replays.watch(recording, vocabulary)

        name = f"{version_of(recording)}.{vocabulary.stem}.watched"
        return Watched.unpack(self._cache.get(name, replay))

    def clip(self, recording: Recording, kind: ClipKind) -> bytes:
        """Return a recording as a GIF, WebP or MP4; raises what ClipMaker.make raises."""
        return self._cache.get(_name(recording, kind), lambda: self._clips.make(recording, kind))


def _name(recording: Recording, kind: ReplayTask | ClipKind) -> str:
    return f"{version_of(recording)}.{kind}"
