"""Disk usage of the data folder."""

from __future__ import annotations

import os
import threading
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from tril.files.artifact_store import ArtifactStore
from tril.settings import Settings

MEASURED_EVERY_S = 10.0
"""Pages poll every few seconds, and walking the files of many trainings takes a while."""


@dataclass(frozen=True)
class StorageUse:
    """Bytes on this machine's disk by purpose.

    Attributes:
        databases_bytes: The databases with their logs.
        artifacts_bytes: The files of trainings; 0 if they are in a remote store.
        cache_bytes: Frames, film strips and clips, which can be derived again.
        other_bytes: The rest of the data folder.
    """

    databases_bytes: int
    artifacts_bytes: int
    cache_bytes: int
    other_bytes: int

    @property
    def total_bytes(self) -> int:
        """The sum."""
        return self.databases_bytes + self.artifacts_bytes + self.cache_bytes + self.other_bytes


class StorageMeter:
    """Measures the data folder, at most every few seconds; thread-safe.

    Args:
        settings: The folders.
        every_s: Greatest age of an answer.
    """

    def __init__(self, settings: Settings, every_s: float = MEASURED_EVERY_S) -> None:
        self._settings = settings
        self._every_s = every_s
        self._lock = threading.Lock()
        self._measured: tuple[float, StorageUse] | None = None

    def use(self) -> StorageUse:
        """Return the last measurement, or a new one if that is too old."""
        with self._lock:
            now = time.monotonic()
            if self._measured is None or now - self._measured[0] > self._every_s:
                self._measured = (now, measure(self._settings))
            return self._measured[1]


def measure(settings: Settings) -> StorageUse:
    """Add up the sizes of the data folder's files; files that vanish meanwhile count as 0."""
    databases = artifacts = cache = other = 0
    artifact_root = ArtifactStore(settings.artifact_root).folder
    for place, size_bytes in _files(settings.data):
        if place.is_relative_to(settings.cache_folder):
            cache += size_bytes
        elif artifact_root and place.is_relative_to(artifact_root):
            artifacts += size_bytes
        elif place.parent == settings.data and ".sqlite" in place.name:
            databases += size_bytes
        else:
            other += size_bytes
    return StorageUse(databases, artifacts, cache, other)


def _files(root: Path) -> Iterator[tuple[Path, int]]:
    for folder, _, names in os.walk(root):
        for name in names:
            place = Path(folder) / name
            try:
                yield place, place.lstat().st_size
            except FileNotFoundError:
                continue
