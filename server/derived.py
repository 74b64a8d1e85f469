"""What is derived from recordings by replay, cached."""

from __future__ import annotations

import hashlib
import threading
from collections.abc import Callable

from server.clips import ClipKind, ClipMaker
from server.memory import memory_file
from server.play.consoles import ConsolePool
from server.play.frames import frames_file, thumbnail_png
from tril.cache import Cache
from tril.game.console import Console
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
        consoles: Where consoles to replay on come from.
        at_once: Most replays at the same time, so that watching does not disturb those who play.
        clips: What makes clips.
    """

    def __init__(
        self,
        cache: Cache,
        consoles: ConsolePool,
        at_once: int = 1,
        clips: ClipMaker | None = None,
    ) -> None:
        self._clips = clips or ClipMaker()
        self._cache = cache
        self._consoles = consoles
        self._turn = threading.BoundedSemaphore(at_once)

    def frames(self, recording: Recording) -> bytes:
        """Return every frame of a recording, as docs/protocol.md describes."""
        return self._made(recording, "frames", frames_file)

    def thumbnail(self, recording: Recording) -> bytes:
        """Return a PNG of a recording."""
        return self._made(recording, "png", thumbnail_png)

    def memory(self, recording: Recording) -> bytes:
        """Return the RAM at the start and after every frame, 128 bytes each."""
        return self._made(recording, "ram", memory_file)

    def clip(self, recording: Recording, kind: ClipKind) -> bytes:
        """Return a recording as a GIF, WebP or MP4; raises what ClipMaker.make raises."""
        name = f"{version_of(recording)}.{kind}"
        return self._cache.get(name, lambda: self._clips.make(recording, kind))

    def _made(
        self, recording: Recording, kind: str, make: Callable[[Recording, Console], bytes]
    ) -> bytes:
        def in_turn() -> bytes:
            with self._turn, self._consoles.lent() as console:
                return make(recording, console)

        return self._cache.get(f"{version_of(recording)}.{kind}", in_turn)
