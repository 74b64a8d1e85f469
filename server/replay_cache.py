"""Files derived from recordings by replay, cached on disk."""

from __future__ import annotations

import hashlib
import threading
import time
from collections.abc import Mapping

from server.clips import ClipKind, ClipMaker
from server.play.replays import ReplayProcess, ReplayTask
from tril.files.cache import Cache
from tril.game.episode import Ending
from tril.recording import Recording

_FORMAT = 1
"""Raised whenever the files change, so that cached ones of an earlier version are not used."""

MAX_RECENT = 1000
"""Products kept in memory for get_within: 7 MB of final pictures."""


def version_of(recording: Recording) -> str:
    """Return a short digest of everything that a replay depends on."""
    start = recording.start
    digest = hashlib.blake2b(recording.actions, digest_size=10)
    ending = () if recording.ending is Ending.HIT else (str(recording.ending),)
    rest = (_FORMAT, recording.rom_md5, start.idle_frames, start.mode, start.difficulty, *ending)
    digest.update(repr(rest).encode())
    return digest.hexdigest()


class ReplayCache:
    """Frames, thumbnails, memory, observations and clips of recordings; thread-safe.

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
        self._recent: dict[str, bytes] = {}

    def get(self, recording: Recording, task: ReplayTask) -> bytes:
        """Return what a replay yields, replaying the recording unless the file is cached."""

        def replay() -> bytes:
            with self._lock:
                return self._replays.submit(task, recording).result()

        return self._cache.get(_name(recording, task), replay)

    def get_within(
        self, budget_s: float, recordings: Mapping[int, Recording], task: ReplayTask
    ) -> dict[int, bytes]:
        """Return what replays of recordings yield, as far as it is cached or time allows.

        At least one of those that are missing is replayed, and the newest are kept in memory, so
        that asking again gets on even where nothing can be cached on disk.

        Args:
            budget_s: Time after which no further replay begins.
            recordings: Recordings by id, the most important first.
            task: What to replay them for.
        """
        deadline = time.monotonic() + budget_s
        names = {key: _name(recording, task) for key, recording in recordings.items()}
        found = {
            key: self._recent.get(name) or self._cache.find(name) for key, name in names.items()
        }
        for key in [key for key, content in found.items() if content is None]:
            found[key] = self.get(recordings[key], task)
            if time.monotonic() > deadline:
                break
        known = {key: content for key, content in found.items() if content is not None}
        newest = self._recent | {names[key]: content for key, content in known.items()}
        self._recent = dict(list(newest.items())[-MAX_RECENT:])
        return known

    def clip(self, recording: Recording, kind: ClipKind) -> bytes:
        """Return a recording as a GIF, WebP or MP4; raises what ClipMaker.make raises."""
        return self._cache.get(_name(recording, kind), lambda: self._clips.make(recording, kind))


def _name(recording: Recording, kind: ReplayTask | ClipKind) -> str:
    return f"{version_of(recording)}.{kind}"
