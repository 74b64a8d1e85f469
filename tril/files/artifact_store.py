"""The store of runs' files: a folder or any store that fsspec supports."""

from __future__ import annotations

import errno
import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path, PurePosixPath

import fsspec
from fsspec.implementations.local import LocalFileSystem

from tril.errors import Invalid, NotFound, Unavailable


class ArtifactStore:
    """Files by relative path such as ``runs/<id>/reward-model.safetensors``.

    Writes are atomic: in a folder by way of a temporary file, in object stores by themselves.

    Args:
        root: Folder or fsspec URL of the store.
    """

    def __init__(self, root: str) -> None:
        self._url = root
        try:
            self._files, self._root = fsspec.core.url_to_fs(root)
        except ImportError as error:
            raise Unavailable(
                f"The artifact store (TRIL_ARTIFACTS_URL) needs a package that is missing: {error}."
            ) from error

    @property
    def is_local(self) -> bool:
        """Whether the store is a local folder."""
        return isinstance(self._files, LocalFileSystem)

    @property
    def url(self) -> str:
        """Return the store's URL; that of a local folder is its absolute path."""
        return str(self._root) if self.is_local else self._url

    def put(self, path: str, content: bytes) -> int:
        """Write a file, replacing an existing one; return its size in bytes.

        Raises:
            Unavailable: The disk is full.
        """
        place = self._place(path)
        if self.is_local:
            with _report_full_disk():
                write_whole(Path(place), content)
        else:
            self._files.pipe_file(place, content)
        return len(content)

    def get(self, path: str) -> bytes:
        """Return a file's content; raises NotFound if there is none."""
        try:
            content: bytes = self._files.cat_file(self._place(path))
        except FileNotFoundError:
            raise NotFound(f"The file {path} is not in the artifact store.") from None
        return content

    @contextmanager
    def local(self, path: str) -> Iterator[Path]:
        """Provide a local path to read the file from within a block."""
        if self.is_local:
            place = Path(self._place(path))
            if not place.is_file():
                raise NotFound(f"The file {path} is not in the artifact store.")
            yield place
            return
        with tempfile.TemporaryDirectory(prefix="tril-") as folder:
            copy = Path(folder) / PurePosixPath(path).name
            copy.write_bytes(self.get(path))
            yield copy

    def exists(self, path: str) -> bool:
        """Return whether the file exists."""
        found: bool = self._files.isfile(self._place(path))
        return found

    def names(self, path: str) -> list[str]:
        """Return the names of what lies in a folder, sorted; none if there is no such folder.

        Files that are being written are left out.
        """
        try:
            found = self._files.ls(self._place(path), detail=False)
        except FileNotFoundError:
            return []
        names = sorted(PurePosixPath(one).name for one in found)
        return [name for name in names if not name.startswith(".")]

    def remove(self, path: str) -> None:
        """Remove a file, if it is there."""
        with suppress(FileNotFoundError):
            self._files.rm_file(self._place(path))

    def remove_folder(self, path: str) -> None:
        """Remove everything below a path, if there is anything."""
        place = self._place(path)
        if self._files.exists(place):
            self._files.rm(place, recursive=True)

    def _place(self, path: str) -> str:
        parts = PurePosixPath(path).parts
        if not parts or path.startswith("/") or "\\" in path or ".." in parts or "\0" in path:
            raise Invalid(f"Expected a relative path inside the artifact store, got {path!r}.")
        return "/".join([str(self._root).rstrip("/"), *parts])


def write_whole(place: Path, content: bytes, mode: int = 0o644) -> None:
    """Write a file atomically and durably: temporary file, fsync, rename."""
    place.parent.mkdir(parents=True, exist_ok=True)
    descriptor, name = tempfile.mkstemp(dir=place.parent, prefix=f".{place.name[:40]}-")
    try:
        with os.fdopen(descriptor, "wb") as file:
            file.write(content)
            file.flush()
            os.fchmod(file.fileno(), mode)
            os.fsync(file.fileno())
        os.replace(name, place)
    except BaseException:
        Path(name).unlink(missing_ok=True)
        raise
    _sync_folder(place.parent)


def _sync_folder(folder: Path) -> None:
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


@contextmanager
def _report_full_disk() -> Iterator[None]:
    try:
        yield
    except OSError as error:
        if error.errno in {errno.ENOSPC, errno.EDQUOT}:
            raise Unavailable(DISK_FULL) from error
        raise


DISK_FULL = "The disk is full. Free some space, then resume. Everything saved so far is kept."


def free_bytes(folder: Path) -> int:
    """Return the free bytes on a folder's disk."""
    return shutil.disk_usage(folder).free
