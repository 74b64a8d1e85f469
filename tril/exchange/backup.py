"""Backups of everything a person made, taken while Tril runs, and checked.

A backup is a folder laid out as a data folder: ``TRIL_DATA=BACKUP tril up`` works on it. It holds
the two databases (by SQLite's own online backup: one consistent state of each, and nobody waits),
the files of trainings, and a manifest with a digest of each file. Left out are caches, which can be
made again, and the access token, which a new folder makes for itself.
"""

from __future__ import annotations

import hashlib
import json
import os
import shutil
import sqlite3
import tempfile
from collections.abc import Iterator
from contextlib import closing
from dataclasses import asdict, dataclass, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from sqlalchemy import make_url

from tril import __version__
from tril.errors import Conflict, Invalid, Unavailable
from tril.files.artifact_store import ArtifactStore, free_bytes, write_whole
from tril.settings import Settings

FORMAT = "tril-backup"
FORMAT_VERSION = 1
MANIFEST = "manifest.json"

TRIES = 3
"""A training that is deleted between the copies of database and files makes another try needed."""

_CHUNK_BYTES = 1024 * 1024
_UNDER_WAY = ("queued", "running", "cancelling")


class BackupDamaged(Invalid):
    """A backup that is not what it says of itself."""


@dataclass(frozen=True)
class CopiedFile:
    """A file of a backup.

    Attributes:
        path: Its path in the backup's folder, with slashes.
        size_bytes: Its length.
        blake2b: Its BLAKE2b digest of 16 bytes, in hexadecimal.
    """

    path: str
    size_bytes: int
    blake2b: str


@dataclass(frozen=True)
class Backup:
    """A backup that has been checked.

    Attributes:
        folder: Where it is.
        n_files: Files in it, databases included.
        size_bytes: What they take together.
        n_recordings: Recordings in its library, deleted ones and those of trainings included.
        n_runs: Trainings.
        notices: What is worth knowing of it.
    """

    folder: Path
    n_files: int
    size_bytes: int
    n_recordings: int
    n_runs: int
    notices: tuple[str, ...] = ()


def make_backup(settings: Settings, folder: Path) -> Backup:
    """Back up a data folder that may be in use, and check the backup.

    The folder appears when the backup is whole; one that was broken off leaves none.

    Args:
        settings: Which data.
        folder: Where to; it may not exist yet, or be empty.

    Raises:
        Conflict: Something is in the folder.
        Unavailable: A database is not SQLite or not there, or there is no room.
        BackupDamaged: The copy does not pass its check: the data are damaged or the disk is.
    """
    databases = {
        # The queue first: a run that has no job is given one, a job that has no run is an orphan.
        "jobs.sqlite": _sqlite_file(settings.queue_url, "job queue's"),
        "tril.sqlite": _sqlite_file(settings.application_url, "application's"),
    }
    folder = folder.absolute()
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise Conflict(f"{folder} is not empty. Name a folder that does not exist yet.")
    folder.parent.mkdir(parents=True, exist_ok=True)
    _check_room(folder.parent, [*databases.values(), *_artifact_files(settings)])
    for attempt in range(1, TRIES + 1):
        unfinished = Path(tempfile.mkdtemp(prefix=f".{folder.name}-", dir=folder.parent))
        try:
            _copy(settings, databases, unfinished)
            made = check_backup(unfinished)
            if folder.exists():
                folder.rmdir()
            unfinished.rename(folder)
        except BackupDamaged:
            if attempt == TRIES:
                raise
            continue
        finally:
            shutil.rmtree(unfinished, ignore_errors=True)
        return replace(made, folder=folder)
    raise AssertionError("unreachable: the last try returns or raises")


def check_backup(folder: Path) -> Backup:
    """Check a backup: every digest, both databases' integrity, and that no run's file is missing.

    Raises:
        BackupDamaged: It is none, or something in it is missing or changed.
    """
    manifest = _read_manifest(folder)
    files = [CopiedFile(**entry) for entry in manifest["files"]]
    for file in files:
        place = folder / file.path
        if not place.is_file():
            raise BackupDamaged(f"{file.path} is missing in {folder}.")
        if _digest(place) != (file.size_bytes, file.blake2b):
            raise BackupDamaged(f"{file.path} in {folder} is not what was written.")
    for name in ("jobs.sqlite", "tril.sqlite"):
        _check_database(folder / name)
    with closing(_opened(folder / "tril.sqlite")) as database:
        if (elsewhere := manifest["artifacts_elsewhere"]) is None:
            notices = _check_artifacts(database, folder)
        else:
            notices = [
                f"The files of trainings are in the artifact store {elsewhere} and not in this"
                " backup; back them up there."
            ]
        (n_recordings,) = database.execute("SELECT count(*) FROM recordings").fetchone()
        (n_runs,) = database.execute("SELECT count(*) FROM runs").fetchone()
    return Backup(
        folder,
        len(files),
        sum(file.size_bytes for file in files),
        n_recordings,
        n_runs,
        tuple(notices),
    )


def _copy(settings: Settings, databases: dict[str, Path], folder: Path) -> None:
    files = []
    for name, source in databases.items():
        _copy_database(source, folder / name)
        files.append(CopiedFile(name, *_digest(folder / name)))
    root = Path(settings.artifact_root)
    for source in _artifact_files(settings):
        path = (Path("artifacts") / source.relative_to(root)).as_posix()
        try:
            files.append(CopiedFile(path, *_copy_file(source, folder / path)))
        except FileNotFoundError:
            continue  # deleted meanwhile; the check tells whether it is needed
    is_local = ArtifactStore(settings.artifact_root).is_local
    manifest = {
        "format": FORMAT,
        "version": FORMAT_VERSION,
        "tril": __version__,
        "created_at": datetime.now(UTC).isoformat(timespec="seconds"),
        "artifacts_elsewhere": None if is_local else settings.artifact_root,
        "files": [asdict(file) for file in files],
    }
    write_whole(folder / MANIFEST, f"{json.dumps(manifest, indent=1)}\n".encode())


def _copy_database(source: Path, to: Path) -> None:
    # In one step, so that it is one state however much is written meanwhile.
    with closing(sqlite3.connect(source)) as live, closing(sqlite3.connect(to)) as copy:
        live.backup(copy, pages=-1)
        # One file, without a log beside it, until somebody works on it.
        copy.execute("PRAGMA journal_mode=DELETE")
    descriptor = os.open(to, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def _copy_file(source: Path, to: Path) -> tuple[int, str]:
    """Copy a file and return its size and digest, taken of what was read."""
    digest, size = hashlib.blake2b(digest_size=16), 0
    with source.open("rb") as given:
        to.parent.mkdir(parents=True, exist_ok=True)
        with to.open("wb") as written:
            while chunk := given.read(_CHUNK_BYTES):
                digest.update(chunk)
                size += written.write(chunk)
            written.flush()
            os.fsync(written.fileno())
    return size, digest.hexdigest()


def _digest(place: Path) -> tuple[int, str]:
    with place.open("rb") as file:
        found = hashlib.file_digest(file, lambda: hashlib.blake2b(digest_size=16))
        return file.tell(), found.hexdigest()


def _artifact_files(settings: Settings) -> Iterator[Path]:
    """Yield the files of trainings, without those that are being written."""
    if not ArtifactStore(settings.artifact_root).is_local:
        return
    for folder, _, names in os.walk(settings.artifact_root):
        yield from (Path(folder) / name for name in sorted(names) if not name.startswith("."))


def _check_room(folder: Path, sources: list[Path]) -> None:
    needed = sum(source.stat().st_size for source in sources if source.exists())
    free = free_bytes(folder)
    if needed > free:
        raise Unavailable(
            f"The backup takes {needed / 1e6:.0f} MB, and {free / 1e6:.0f} MB are free in {folder}."
        )


def _sqlite_file(url: str, whose: str) -> Path:
    parsed = make_url(url)
    if parsed.get_backend_name() != "sqlite" or not parsed.database:
        raise Unavailable(
            f"The {whose} database is {parsed.get_backend_name()}, which has tools of its own for"
            " backups (pg_dump for PostgreSQL). `tril backup` is for SQLite."
        )
    place = Path(parsed.database)
    if not place.is_file():
        raise Unavailable(f"There is no database {place} yet, so there is nothing to back up.")
    return place


def _opened(place: Path) -> sqlite3.Connection:
    return sqlite3.connect(f"file:{place.absolute().as_posix()}?mode=ro&immutable=1", uri=True)


def _check_database(place: Path) -> None:
    try:
        with closing(_opened(place)) as database:
            (found,) = database.execute("PRAGMA integrity_check(1)").fetchone()
            broken = database.execute("PRAGMA foreign_key_check").fetchone()
    except sqlite3.DatabaseError as error:
        raise BackupDamaged(f"{place.name} is damaged: {error}.") from error
    if found != "ok":
        raise BackupDamaged(f"{place.name} is damaged: {found}.")
    if broken is not None:
        raise BackupDamaged(f"{place.name} is damaged: a row of {broken[0]} refers to nothing.")


def _check_artifacts(database: sqlite3.Connection, folder: Path) -> list[str]:
    """Compare the files of trainings with what the database says of them."""
    found = database.execute(
        "SELECT artifacts.path, artifacts.size_bytes, runs.id, runs.status FROM artifacts"
        " JOIN runs ON runs.id = artifacts.run_id WHERE runs.deleted_at IS NULL"
    )
    newer = set()
    for path, size_bytes, run_id, status in found:
        place = folder / "artifacts" / path
        if not place.is_file():
            raise BackupDamaged(f"The file {path} of run {run_id} is missing.")
        if place.stat().st_size != size_bytes:
            if status not in _UNDER_WAY:
                raise BackupDamaged(f"The file {path} of run {run_id} has another size.")
            newer.add(run_id)
    return [
        f"Run {run_id} was under way: its files are a moment newer than the database."
        for run_id in sorted(newer)
    ]


def _read_manifest(folder: Path) -> dict[str, Any]:
    try:
        manifest = json.loads((folder / MANIFEST).read_bytes())
    except FileNotFoundError:
        raise BackupDamaged(f"{folder} is no backup of Tril: it has no {MANIFEST}.") from None
    except ValueError as error:
        raise BackupDamaged(f"{MANIFEST} in {folder} can't be read: {error}.") from error
    if not isinstance(manifest, dict) or manifest.get("format") != FORMAT:
        raise BackupDamaged(f"{folder} is no backup of Tril: its {MANIFEST} is of something else.")
    if manifest.get("version") != FORMAT_VERSION:
        raise BackupDamaged(
            f"{folder} was written by another version of Tril (backup version"
            f" {manifest.get('version')}, this one reads {FORMAT_VERSION})."
        )
    return manifest
