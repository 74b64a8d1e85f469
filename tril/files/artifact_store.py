"""The store of runs' files: a folder, S3, or any other store that fsspec supports."""

from __future__ import annotations

import errno
import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from datetime import timedelta
from pathlib import Path, PurePosixPath
from typing import Any, BinaryIO

import fsspec
from fsspec.implementations.local import LocalFileSystem

from tril.errors import Invalid, NotFound, Unavailable

S3_OPTIONS: dict[str, Any] = {
    # Addresses without encryption are used where AWS_ENDPOINT_URL names one.
    "client_options": {"allow_http": True, "connect_timeout": "5s", "timeout": "30s"},
    "retry_config": {"max_retries": 3, "retry_timeout": timedelta(seconds=15)},
}
"""A file of 13 MB in 30 s is 0.4 MB/s. What hangs is given up after 30 s, what fails after 15 s."""

MAX_REASON = 400


class ArtifactStoreUnavailable(Unavailable):
    """The artifact store can't be reached, or refuses; later it may not."""

    def __init__(self, error: Exception) -> None:
        super().__init__(
            "The artifact store, where the files of trainings are, can't be used:"
            f" {_reason(error)} Nothing that it has is lost."
        )


class ArtifactStore:
    """Files by relative path such as ``runs/<id>/reward-model.safetensors``.

    Writes are atomic: in a folder by way of a temporary file, in object stores by themselves.
    Every method raises ArtifactStoreUnavailable if the store can't be reached or refuses.

    Args:
        root: Folder or fsspec URL of the store.

    Raises:
        Unavailable: The package for such a store is missing.
    """

    def __init__(self, root: str) -> None:
        self._url = root
        try:
            self._files, self._root = _opened(root)
        except ImportError as error:
            raise Unavailable(
                "The artifact store (TRIL_ARTIFACTS_URL) needs a package that is missing: "
                f"{error}. For S3: pip install 'tril-imitation[s3]'"
            ) from error

    @property
    def is_local(self) -> bool:
        """Whether the store is a local folder."""
        return isinstance(self._files, LocalFileSystem)

    @property
    def folder(self) -> Path | None:
        """The local folder that is the store; None if it is elsewhere."""
        return Path(self._root) if self.is_local else None

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
        with _reporting(path):
            if self.is_local:
                write_whole(Path(place), content)
            else:
                self._files.pipe_file(place, content)
        return len(content)

    def get(self, path: str) -> bytes:
        """Return a file's content; raises NotFound if there is none."""
        place = self._place(path)
        with _reporting(path):
            content: bytes = self._files.cat_file(place)
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
        place = self._place(path)
        try:
            # Not isfile, which takes every failure for an answer.
            with _reporting(path):
                return bool(self._files.info(place)["type"] == "file")
        except NotFound:
            return False

    def names(self, path: str) -> list[str]:
        """Return the names of what lies in a folder, sorted; none if there is no such folder.

        Files that are being written are left out.
        """
        place = self._place(path)
        try:
            with _reporting(path):
                paths = self._files.ls(place, detail=False)
        except NotFound:
            return []
        names = sorted(PurePosixPath(file).name for file in paths)
        return [name for name in names if not name.startswith(".")]

    def remove(self, path: str) -> None:
        """Remove a file, if it is there."""
        place = self._place(path)
        with suppress(NotFound), _reporting(path):
            self._files.rm_file(place)

    def remove_folder(self, path: str) -> None:
        """Remove everything below a path, if there is anything."""
        place = self._place(path)
        with suppress(NotFound), _reporting(path):
            self._files.rm(place, recursive=True)

    def move_folder(self, path: str, to: str) -> None:
        """Move everything below a path to another, in place of what lies there."""
        place, target = self._place(path), self._place(to)
        self.remove_folder(to)
        with _reporting(path):
            if self.is_local:
                Path(target).parent.mkdir(parents=True, exist_ok=True)
                Path(place).rename(target)
                _sync_folder(Path(target).parent)
                return
            for name in self.names(path):
                self._files.cp_file(f"{place}/{name}", f"{target}/{name}")
            self._files.rm(place, recursive=True)

    def check(self, name: str) -> None:
        """Write a file, list its folder, and remove it again.

        Args:
            name: Name of the file, which nobody else uses.
        """
        path = f"workers/{name}"
        self.put(path, b"")
        self.names("workers")
        self.remove(path)

    def _place(self, path: str) -> str:
        parts = PurePosixPath(path).parts
        if not parts or path.startswith("/") or "\\" in path or ".." in parts or "\0" in path:
            raise Invalid(f"Expected a relative path inside the artifact store, got {path!r}.")
        return "/".join([str(self._root).rstrip("/"), *parts])


def _opened(root: str) -> tuple[Any, str]:
    """Return fsspec's file system of a store, and the store's place in it."""
    if "://" not in root:
        # Not url_to_fs, which takes "::" in a folder's name for a chain of URLs.
        return LocalFileSystem(), LocalFileSystem._strip_protocol(root)
    if not root.startswith("s3://"):
        files, place = fsspec.core.url_to_fs(root)
        return files, place
    from obstore.fsspec import FsspecStore

    # An instance of its own reads the credentials of now. Its types leave out fsspec's options.
    options: dict[str, Any] = {**S3_OPTIONS, "skip_instance_cache": True}
    make: Any = FsspecStore
    return make("s3", **options), root.removeprefix("s3://").rstrip("/")


def write_whole(place: Path, content: bytes, mode: int = 0o600) -> None:
    """Write a file atomically and durably: temporary file, fsync, rename."""
    with whole_file(place, mode) as file:
        file.write(content)


@contextmanager
def whole_file(place: Path, mode: int = 0o600) -> Iterator[BinaryIO]:
    """Open a file for writing that appears at the end of the block, or not at all if that fails."""
    place.parent.mkdir(parents=True, exist_ok=True)
    if place.exists() and not place.is_file():
        # A device or a pipe is written to; a folder is an error.
        with place.open("wb") as file:
            yield file
        return
    descriptor, name = tempfile.mkstemp(dir=place.parent, prefix=f".{place.name[:40]}-")
    try:
        with os.fdopen(descriptor, "wb") as file:
            yield file
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
def _reporting(path: str) -> Iterator[None]:
    """Raise what a store's package raises as an error of Tril.

    Raises:
        NotFound: There is no such file.
        Unavailable: The disk is full.
        ArtifactStoreUnavailable: Anything else.
    """
    try:
        yield
    except FileNotFoundError as error:
        if "NoSuchBucket" in str(error):
            raise ArtifactStoreUnavailable(error) from error
        raise NotFound(f"The file {path} is not in the artifact store.") from None
    except Exception as error:
        # Each package of fsspec has errors of its own.
        if isinstance(error, OSError) and error.errno in {errno.ENOSPC, errno.EDQUOT}:
            raise Unavailable(DISK_FULL) from error
        raise ArtifactStoreUnavailable(error) from error


def _reason(error: Exception) -> str:
    """Return why a store can't be used, and what to do about it where that is known."""
    # obstore adds pages of debugging after an empty line.
    text = " ".join(str(error).partition("\n\n")[0].split())[:MAX_REASON]
    if "169.254.169.254" in text:
        return (
            "there are no credentials on this machine. Set AWS_ACCESS_KEY_ID and"
            " AWS_SECRET_ACCESS_KEY (docs/databases.md)."
        )
    # Of listings, obstore does not tell refusals by their type.
    if any(status in text for status in ("401 Unauthorized", "403 Forbidden")):
        return f"it refuses the credentials of this machine ({text})."
    if "NoSuchBucket" in text:
        return "there is no such bucket. Make it, or correct TRIL_ARTIFACTS_URL."
    return f"{text or type(error).__name__}."


DISK_FULL = "The disk is full. Free some space, then resume. Everything saved so far is kept."


def free_bytes(folder: Path) -> int:
    """Return the free bytes on a folder's disk."""
    return shutil.disk_usage(folder).free
