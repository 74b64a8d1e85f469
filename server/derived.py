"""What is derived from recordings by replay, cached."""

from __future__ import annotations

import hashlib
import threading

from server.clips import ClipKind, ClipMaker
from server.play.replays import ReplayProcess, ReplayTask
from tril.files.cache import Cache
from tril.recording import Recording

_FORMAT = 1
"""Raised with every change of what is made of a recording, so that old files are left alone."""


def version_of(recording: Recording) -> str:
    """Return a short digest of everything that a replay depends on."""
    start = recording.start
    digest = hashlib.blake2b(recording.actions, digest_size=10)
    rest = (_FORMAT, recording.rom_md5, start.idle_frames, start.mode, start.difficulty)
    digest.update(repr(rest).encode())
    return digest.hexdigest()


class Derived:
    """Frames, thumbnails, memory and clips of recordings; safe to call from several threads.

    Args:
        cache: Where they are kept.
        replays: What replays recordings.
        clips: What makes clips.
    """

    def __init__(
        self, cache: Cache, replays: ReplayProcess, clips: ClipMaker | None = None
    ) -> None:
        self._cache = cache
        self._replays = replays
        self._clips = clips or ClipMaker()
        # One at a time, so that the check of a game that ends waits for one at most.
        self._turn = threading.Lock()

    def frames(self, recording: Recording) -> bytes:
        """Return every frame of a recording, as docs/protocol.md describes."""
        return self._made(recording, ReplayTask.FRAMES)

    def thumbnail(self, recording: Recording) -> bytes:
        """Return a PNG of a recording."""
        return self._made(recording, ReplayTask.THUMBNAIL)

    def memory(self, recording: Recording) -> bytes:
        """Return the RAM at the start and after every frame, 128 bytes each."""
        return self._made(recording, ReplayTask.MEMORY)

    def clip(self, recording: Recording, kind: ClipKind) -> bytes:
        """Return a recording as a GIF, WebP or MP4; raises what ClipMaker.make raises."""
        name = f"{version_of(recording)}.{kind}"
        return self._cache.get(name, lambda: self._clips.make(recording, kind))

    def _made(self, recording: Recording, task: ReplayTask) -> bytes:
        def in_turn() -> bytes:
            with self._turn:
                return self._replays.submit(task, recording).result()

        return self._cache.get(f"{version_of(recording)}.{task}", in_turn)
