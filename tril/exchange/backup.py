"""Verified backups of a data folder, taken while Tril runs.

A backup is itself a data folder: ``TRIL_DATA=BACKUP tril up`` works on it. It holds the two
databases (copied with SQLite's online backup, each in one consistent state and without blocking
writers), the artifacts of runs, and a manifest with a digest of each file. It has neither caches
nor the access token, which a new folder creates itself.

Of PostgreSQL it holds dumps, which pg_restore makes a database of. The manifest then also says what
the application's database contains, since a dump can't be asked.
"""

from __future__ import annotations

import hashlib
import json
import os
import re
import shutil
import sqlite3
import stat
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import closing
from dataclasses import asdict, dataclass, replace
from datetime import UTC, datetime
from pathlib import Path

from pydantic import TypeAdapter, ValidationError
from sqlalchemy import Connection, Engine, create_engine, make_url, text
from sqlalchemy.exc import OperationalError

from tril import __version__
from tril.errors import Conflict, Invalid, Unavailable
from tril.exchange.formats.json_text import decode_json, parse_json
from tril.exchange.formats.recording_object import describe_errors
from tril.files.artifact_store import ArtifactStore, free_bytes, write_whole
from tril.settings import Settings
from tril.store.copies import (
    CopyFailed,
    check_dump,
    check_pg_dump,
    copy_sqlite,
    dump_postgresql,
    is_postgresql,
)
from tril.store.schema import known_revisions

FORMAT = "tril-backup"
FORMAT_VERSION = 1
MANIFEST = "manifest.json"

MAX_MANIFEST_BYTES = 64 * 2**20

MAX_ATTEMPTS = 3
"""A run deleted between the copies of the database and of the artifacts makes a retry necessary."""

_CHUNK_BYTES = 1024 * 1024
_ARTIFACTS = (
    "SELECT artifacts.path, artifacts.size_bytes, runs.id, runs.status FROM artifacts"
    " JOIN runs ON runs.id = artifacts.run_id WHERE runs.deleted_at IS NULL"
)
_REVISIONS = "SELECT version_num FROM alembic_version"
_N_RECORDINGS = "SELECT count(*) FROM recordings"
_N_RUNS = "SELECT count(*) FROM runs"
_REFUSING_TRIGGER = re.compile(
    r"CREATE TRIGGER \w+ BEFORE (?:UPDATE|DELETE) ON \w+"
    r" BEGIN SELECT RAISE\(ABORT, '[^']*'\); END"
)
"""The only kind of trigger that Tril's schema has: it changes nothing."""
_UNDER_WAY = ("queued", "running", "cancelling")


class BackupDamaged(Invalid):
    """A backup that is incomplete or was changed."""


@dataclass(frozen=True)
class CopiedFile:
    """A file of a backup.

    Attributes:
        path: Path in the backup, with slashes.
        size_bytes: Size.
        blake2b: BLAKE2b digest of 16 bytes, in hexadecimal.
    """

    path: str
    size_bytes: int
    blake2b: str


@dataclass(frozen=True)
class Contents:
    """What the application's database contains.

    Attributes:
        n_recordings: Number of recordings, including deleted ones and those of runs.
        n_runs: Number of runs.
        artifacts: Path, size, run and run status of each file.
    """

    n_recordings: int
    n_runs: int
    artifacts: list[tuple[str, int, str, str]]


@dataclass(frozen=True)
class Manifest:
    """What a backup says of itself.

    Attributes:
        files: Files of the backup.
        artifacts_elsewhere: URL of the artifact store, if the runs' files are not in the backup.
        contents: Contents of the application's database, if the backup has a dump of it.
    """

    files: list[CopiedFile]
    artifacts_elsewhere: str | None
    contents: Contents | None = None


@dataclass(frozen=True)
class Backup:
    """A verified backup.

    Attributes:
        folder: Folder of the backup.
        n_files: Number of files, including the databases.
        size_bytes: Total size.
        n_recordings: Number of recordings, including deleted ones and those of runs.
        n_runs: Number of runs.
        notices: Messages about what it lacks.
    """

    folder: Path
    n_files: int
    size_bytes: int
    n_recordings: int
    n_runs: int
    notices: tuple[str, ...] = ()


def make_backup(settings: Settings, folder: Path) -> Backup:
    """Back up a data folder that may be in use, and verify the backup.

    The folder appears once the backup is complete.

    Args:
        settings: The data folder's settings.
        folder: The backup's folder, new or empty.

    Raises:
        Conflict: The folder is not empty.
        Unavailable: A database is missing or can't be copied, or there is too little space.
        BackupDamaged: The copy fails verification: the data or the disk are damaged.
    """
    # The queue first: a run without a job is given one, a job without a run is an orphan.
    databases: dict[str, Path | Engine] = {}
    for whose, name, url in (
        ("job queue's", "jobs", settings.queue_url),
        ("application's", "tril", settings.application_url),
    ):
        if not is_postgresql(url):
            databases[f"{name}.sqlite"] = _sqlite_file(url, whose)
        elif name == "tril" or url != settings.application_url:
            databases[f"{name}.dump"] = create_engine(url, pool_size=1)
    try:
        return _make_backup(settings, databases, folder.absolute())
    except OperationalError as error:
        raise Unavailable(f"The database can't be reached: {error.orig}.") from error
    finally:
        for source in databases.values():
            if isinstance(source, Engine):
                source.dispose()


def _make_backup(settings: Settings, databases: dict[str, Path | Engine], folder: Path) -> Backup:
    for source in databases.values():
        if isinstance(source, Engine):
            check_pg_dump(source)
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise Conflict(f"{folder} is not empty. Choose a new folder.")
    folder.parent.mkdir(parents=True, exist_ok=True)
    store = ArtifactStore(settings.artifact_root)
    sizes = [*map(_size, databases.values()), *map(_size, _artifact_files(store.folder))]
    _check_free_space(folder.parent, sum(sizes))
    for attempt in range(1, MAX_ATTEMPTS + 1):
        unfinished = Path(tempfile.mkdtemp(prefix=f".{folder.name}-", dir=folder.parent))
        try:
            _copy(settings, databases, unfinished)
            backup = check_backup(unfinished)
            if folder.exists():
                folder.rmdir()
            unfinished.rename(folder)
        except BackupDamaged:
            if attempt == MAX_ATTEMPTS:
                raise
            continue
        finally:
            shutil.rmtree(unfinished, ignore_errors=True)
        return replace(backup, folder=folder)
    raise AssertionError("unreachable: the last try returns or raises")


def check_backup(folder: Path) -> Backup:
    """Verify a backup: digests, integrity of the databases, completeness of the artifacts.

    Raises:
        BackupDamaged: It is not a backup, or a file is missing or was changed.
    """
    manifest = _read_manifest(folder)
    files = manifest.files
    present = dict(_entries(folder))
    for file in files:
        place = folder / file.path
        if file.path not in present:
            raise BackupDamaged(f"{file.path[:200]!r} is missing in {folder}.")
        if _digest(place) != (file.size_bytes, file.blake2b):
            raise BackupDamaged(f"{file.path} in {folder} was changed after the backup.")
    names = {file.path for file in files}
    if unlisted := sorted(present.keys() - names - {MANIFEST}):
        # Such as a database's log, a key, or a file that a program would read beside it.
        raise BackupDamaged(f"{unlisted[0][:200]!r} in {folder} is not of the backup. Remove it.")
    has_dump = "tril.dump" in names
    for name in sorted(names & {"jobs.dump", "tril.dump"}):
        try:
            check_dump(folder / name)
        except CopyFailed as error:
            raise BackupDamaged(f"{name} is damaged: {error}") from error
    # The application's dump may have the queue, too.
    for name in ["jobs.sqlite", "tril.sqlite"] if not has_dump else sorted(names & {"jobs.sqlite"}):
        _check_database(folder / name)
    if has_dump:
        if manifest.contents is None:
            raise BackupDamaged(f"{MANIFEST} in {folder} does not say what the database contains.")
        contents = manifest.contents
    else:
        contents = _contents_of_file(folder / "tril.sqlite")
    if (elsewhere := manifest.artifacts_elsewhere) is None:
        notices = _check_artifacts(contents, present)
    else:
        notices = [
            f"The files of runs are in the artifact store {elsewhere}, not in this backup."
            " Back them up there."
        ]
    return Backup(
        folder,
        len(files),
        sum(file.size_bytes for file in files),
        contents.n_recordings,
        contents.n_runs,
        tuple(notices),
    )


def _copy(settings: Settings, databases: dict[str, Path | Engine], folder: Path) -> None:
    files = []
    contents: Contents | None = None
    for name, source in databases.items():
        if isinstance(source, Path):
            copy_sqlite(source, folder / name)
        elif name == "tril.dump":
            contents = _dump_with_contents(source, folder / name)
        else:
            dump_postgresql(source, folder / name)
        files.append(CopiedFile(name, *_digest(folder / name)))
    root = ArtifactStore(settings.artifact_root).folder
    for source in _artifact_files(root):
        assert root is not None
        path = (Path("artifacts") / source.relative_to(root)).as_posix()
        try:
            files.append(CopiedFile(path, *_copy_file(source, folder / path)))
        except FileNotFoundError:
            continue  # deleted meanwhile; the check finds out whether it is needed
    manifest = {
        "format": FORMAT,
        "version": FORMAT_VERSION,
        "tril": __version__,
        "created_at": datetime.now(UTC).isoformat(timespec="seconds"),
        "artifacts_elsewhere": None if root else settings.artifact_root,
        "files": [asdict(file) for file in files],
        **({} if contents is None else {"contents": asdict(contents)}),
    }
    write_whole(folder / MANIFEST, f"{json.dumps(manifest, indent=1)}\n".encode())


def _dump_with_contents(engine: Engine, to: Path) -> Contents:
    """Dump a database; return what it contains in the very state that is dumped."""
    with engine.execution_options(isolation_level="REPEATABLE READ").connect() as connection:
        snapshot = connection.execute(text("SELECT pg_export_snapshot()")).scalar_one()
        dump_postgresql(engine, to, snapshot)
        return _contents(connection)


def _contents(connection: Connection) -> Contents:
    return Contents(
        connection.execute(text(_N_RECORDINGS)).scalar_one(),
        connection.execute(text(_N_RUNS)).scalar_one(),
        [(row[0], row[1], row[2], row[3]) for row in connection.execute(text(_ARTIFACTS))],
    )


def _contents_of_file(place: Path) -> Contents:
    try:
        with closing(_open_read_only(place)) as database:
            revisions = {revision for (revision,) in database.execute(_REVISIONS)}
            (n_recordings,) = database.execute(_N_RECORDINGS).fetchone()
            (n_runs,) = database.execute(_N_RUNS).fetchone()
            contents = Contents(n_recordings, n_runs, database.execute(_ARTIFACTS).fetchall())
    except sqlite3.DatabaseError as error:
        raise BackupDamaged(f"{place.name} is no database of Tril: {error}.") from error
    if not revisions <= known_revisions():
        raise BackupDamaged(
            f"{place.name} was written by a newer version of Tril, which this one can't read."
            " Update Tril."
        )
    return contents


def _copy_file(source: Path, to: Path) -> tuple[int, str]:
    """Copy a file; return the size and digest of the bytes read."""
    digest, size = hashlib.blake2b(digest_size=16), 0
    with source.open("rb") as original:
        to.parent.mkdir(parents=True, exist_ok=True)
        with to.open("wb") as copy:
            while chunk := original.read(_CHUNK_BYTES):
                digest.update(chunk)
                size += copy.write(chunk)
            copy.flush()
            os.fsync(copy.fileno())
    return size, digest.hexdigest()


def _digest(place: Path) -> tuple[int, str]:
    with place.open("rb") as file:
        digest = hashlib.file_digest(file, lambda: hashlib.blake2b(digest_size=16))
        return file.tell(), digest.hexdigest()


def _artifact_files(root: Path | None) -> Iterator[Path]:
    """Yield the complete files of an artifact store in a local folder."""
    for folder, _, names in os.walk(root) if root else ():
        yield from (Path(folder) / name for name in sorted(names) if not name.startswith("."))


def _size(source: Path | Engine) -> int:
    """Return about how many bytes the copy of a file or database takes."""
    if isinstance(source, Path):
        return source.stat().st_size if source.exists() else 0
    with source.connect() as connection:
        return int(connection.scalar(text("SELECT pg_database_size(current_database())")) or 0)


def _check_free_space(folder: Path, needed: int) -> None:
    free = free_bytes(folder)
    if needed > free:
        raise Unavailable(
            f"The backup needs {needed / 1e6:.0f} MB, but only {free / 1e6:.0f} MB are free in"
            f" {folder}. Choose another disk."
        )


def _sqlite_file(url: str, whose: str) -> Path:
    parsed = make_url(url)
    if parsed.get_backend_name() != "sqlite" or not parsed.database:
        raise Unavailable(
            f"The {whose} database is {parsed.get_backend_name()}, but `tril backup` supports only"
            " SQLite and PostgreSQL. Use the database's own tools."
        )
    place = Path(parsed.database)
    if not place.is_file():
        raise Unavailable(f"There is nothing to back up: the database {place} does not exist.")
    return place


def _open_read_only(place: Path) -> sqlite3.Connection:
    return sqlite3.connect(f"{place.absolute().as_uri()}?mode=ro&immutable=1", uri=True)


def _check_database(place: Path) -> None:
    try:
        with closing(_open_read_only(place)) as database:
            (verdict,) = database.execute("PRAGMA integrity_check(1)").fetchone()
            broken = database.execute("PRAGMA foreign_key_check").fetchone()
            foreign = _foreign_objects(database)
    except sqlite3.DatabaseError as error:
        raise BackupDamaged(f"{place.name} is damaged: {error}.") from error
    if verdict != "ok":
        raise BackupDamaged(f"{place.name} is damaged: {verdict}.")
    if foreign:
        raise BackupDamaged(
            f"{place.name} was not written by Tril alone: it has {foreign[0][:80]!r}."
        )
    if broken is not None:
        raise BackupDamaged(
            f"{place.name} is damaged: a row of {broken[0]} has a dangling foreign key."
        )


def _foreign_objects(database: sqlite3.Connection) -> list[str]:
    """Return names of what acts by itself or shows other tables, and is not of Tril's schema."""
    rows = database.execute(
        "SELECT name, sql FROM sqlite_master WHERE type NOT IN ('table', 'index')"
        " OR sql LIKE 'CREATE VIRTUAL %'"
    )
    return [str(name) for name, sql in rows if not _REFUSING_TRIGGER.fullmatch(str(sql))]


def _entries(folder: Path) -> Iterator[tuple[str, int]]:
    """Yield path and size of each file of a backup.

    Raises:
        BackupDamaged: Something in it is neither a file nor a folder.
    """
    for place, folders, names in os.walk(folder):
        for name in (*folders, *names):
            path = Path(place) / name
            status = path.lstat()
            if stat.S_ISREG(status.st_mode):
                yield path.relative_to(folder).as_posix(), status.st_size
            elif not stat.S_ISDIR(status.st_mode):
                raise BackupDamaged(f"{path} is neither a file nor a folder.")


def _check_artifacts(contents: Contents, present: Mapping[str, int]) -> list[str]:
    """Compare the artifacts with the database; return notices about runs under way."""
    newer = set()
    for path, size_bytes, run_id, status in contents.artifacts:
        size = present.get(f"artifacts/{path}")
        if size is None:
            raise BackupDamaged(f"The file {path} of run {run_id} is missing.")
        if size != size_bytes:
            if status not in _UNDER_WAY:
                raise BackupDamaged(f"The file {path} of run {run_id} has the wrong size.")
            newer.add(run_id)
    return [
        f"Run {run_id} was under way, so its files are slightly newer than the database."
        for run_id in sorted(newer)
    ]


def _read_manifest(folder: Path) -> Manifest:
    try:
        with (folder / MANIFEST).open("rb") as file:
            content = file.read(MAX_MANIFEST_BYTES + 1)
        if len(content) > MAX_MANIFEST_BYTES:
            raise BackupDamaged(f"{MANIFEST} in {folder} is too large.")
        manifest = parse_json(decode_json(content))
    except FileNotFoundError:
        raise BackupDamaged(f"{folder} is not a Tril backup: it has no {MANIFEST}.") from None
    except ValueError as error:
        raise BackupDamaged(f"{MANIFEST} in {folder} can't be read: {error}.") from error
    if not isinstance(manifest, dict) or manifest.get("format") != FORMAT:
        raise BackupDamaged(f"{folder} is not a Tril backup: its {MANIFEST} has another format.")
    if manifest.get("version") != FORMAT_VERSION:
        raise BackupDamaged(
            f"{folder} was written by another version of Tril (backup version"
            f" {manifest.get('version')}, this one reads {FORMAT_VERSION})."
        )
    try:
        return TypeAdapter(Manifest).validate_python(manifest)
    except ValidationError as error:
        raise BackupDamaged(
            f"{MANIFEST} in {folder} can't be read: {' '.join(describe_errors(error))}"
        ) from None
