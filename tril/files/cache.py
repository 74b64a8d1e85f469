"""A bounded disk cache of reproducible files such as frames and film strips.

Files are named by their inputs and therefore never stale; the least recently used are evicted
first. Several processes may share a folder.
"""

from __future__ import annotations

import hashlib
import logging
import os
import threading
import time
from collections.abc import Callable
from pathlib import Path

from tril.files.artifact_store import write_whole

_LOG = logging.getLogger(__name__)

_DIGEST_BYTES = 16
"""Of the digest that each file begins with."""
_SWEPT_TO = 0.9
"""Share of the limit left by a sweep, so that not every new file causes one."""
_ABANDONED_AFTER_S = 600.0
"""Age after which a temporary file must be of a killed process."""


class Cache:
    """Files by name in a folder of limited size.

    Args:
        folder: The folder, created with the first file.
        limit_bytes: Maximum total size; 0 caches nothing.
    """

    def __init__(self, folder: Path, limit_bytes: int) -> None:
        self._folder = folder
        self._limit_bytes = limit_bytes
        self._lock = threading.Lock()
        self._making: dict[str, threading.Lock] = {}
        self._used_bytes: int | None = None

    def get(self, name: str, make: Callable[[], bytes]) -> bytes:
        """Return a file's content, making it if necessary, once for concurrent callers.

        A file that can't be written is returned all the same.

        Args:
            name: Name derived from the inputs, in letters, digits, dots and hyphens.
            make: Makes the content.
        """
        _check_name(name)
        with self._lock:
            lock = self._making.setdefault(name, threading.Lock())
        with lock:
            try:
                content = self.find(name)
                if content is None:
                    content = make()
                    self._keep(name, content)
            finally:
                with self._lock:
                    self._making.pop(name, None)
        return content

    def find(self, name: str) -> bytes | None:
        """Return a file's content, None if it is not cached."""
        _check_name(name)
        path = self._folder / name
        try:
            file = path.read_bytes()
            os.utime(path)
        except FileNotFoundError:
            return None
        except OSError as error:
            _LOG.warning("The cached file %s can't be read: %s", name, error)
            return None
        content = file[_DIGEST_BYTES:]
        if file != sealed(content):
            _LOG.warning("The cached file %s was damaged; it is derived again.", name)
            return None
        return content

    def _keep(self, name: str, content: bytes) -> None:
        file = sealed(content)
        if len(file) > self._limit_bytes:
            return
        try:
            write_whole(self._folder / name, file)
        except OSError as error:
            _LOG.warning("The file %s could not be cached: %s", name, error)
            return
        with self._lock:
            if self._used_bytes is None:
                self._used_bytes = sum(size for _, size, _ in self._files())
            else:
                self._used_bytes += len(file)
            if self._used_bytes > self._limit_bytes:
                self._used_bytes = self._sweep()

    def _files(self) -> list[tuple[float, int, Path]]:
        """Return (time of last use, size, path) of every file, temporary ones too."""
        files = []
        with os.scandir(self._folder) as entries:
            for entry in entries:
                try:
                    status = entry.stat(follow_symlinks=False)
                except FileNotFoundError:
                    continue
                if entry.is_file(follow_symlinks=False):
                    files.append((status.st_mtime, status.st_size, Path(entry.path)))
        return files

    def _sweep(self) -> int:
        used = 0
        room = int(self._limit_bytes * _SWEPT_TO)
        for used_at, size, path in sorted(self._files(), reverse=True):
            is_temporary = path.name.startswith(".")
            if is_temporary and time.time() - used_at < _ABANDONED_AFTER_S:
                continue
            if is_temporary or used + size > room:
                path.unlink(missing_ok=True)
            else:
                used += size
        return used


def sealed(content: bytes) -> bytes:
    """Return a cached file: a digest of its content, then the content."""
    return hashlib.blake2b(content, digest_size=_DIGEST_BYTES).digest() + content


def _check_name(name: str) -> None:
    if not name.replace("-", "").replace(".", "").isalnum() or name.startswith("."):
        raise ValueError(f"Expected a plain file name, got {name!r}.")
