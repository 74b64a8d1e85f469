"""Folders and files that other users of the machine can't read."""

from __future__ import annotations

import os
import stat
from collections.abc import Iterator
from pathlib import Path

UMASK = 0o077
"""What entry points set, so that every file is its user's alone: databases with what SQLite writes
beside them, artifacts, caches, logs, sockets, exports and backups."""

_OURS = ("tril.sqlite", "jobs.sqlite", "secrets.json")
"""Files by which a data folder is known."""


def make_private(folder: Path) -> bool:
    """Take the rights of other users from a data folder that earlier versions left open to them.

    Within a folder that has other things in it, only what Tril writes there is changed, and the
    folder itself only if it is Tril's.

    Args:
        folder: The data folder.

    Returns:
        Whether other users can't enter it now.
    """
    if not _is_open(folder):
        return True
    names = {path.name for path in folder.iterdir()}
    is_ours = not names or bool(names.intersection(_OURS))
    is_shared_by_nature = bool(folder.stat().st_mode & stat.S_ISVTX)
    if not is_ours or is_shared_by_nature:
        return False
    try:
        # The folder last: until then it shows that there is something to do.
        for path in (*_written(folder), folder):
            _close(path)
    except PermissionError:
        return False
    return True


def _written(folder: Path) -> Iterator[Path]:
    for pattern in ("*.sqlite*", "*.lock", "*.sock", "secrets.json"):
        yield from folder.glob(pattern)
    for name in ("artifacts", "before-upgrades", "cache", "logs", "results", "runs", "workers"):
        yield from (folder / name).rglob("*")
        yield folder / name


def _is_open(path: Path) -> bool:
    return bool(path.stat().st_mode & UMASK)


def _close(path: Path) -> None:
    try:
        mode = path.lstat().st_mode
        if not stat.S_ISLNK(mode) and mode & UMASK:
            os.chmod(path, stat.S_IMODE(mode) & ~UMASK)
    except FileNotFoundError:
        pass  # Other processes remove what they need no more.
