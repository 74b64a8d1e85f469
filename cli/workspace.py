"""The opened data folder that commands work on."""

from __future__ import annotations

import fcntl
import shlex
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

from sqlalchemy.orm import Session

from cli.output import errors, read_settings, readable_errors
from tril.errors import Unavailable
from tril.files.private import make_private
from tril.jobs import Jobs, prepare_queue
from tril.settings import Settings
from tril.store import behaviours
from tril.store.copies import CopyFailed
from tril.store.database import Database, create_database
from tril.store.models import BehaviourRow
from tril.store.schema import upgrade


@dataclass(frozen=True)
class Workspace:
    """An opened data folder."""

    settings: Settings
    database: Database

    @contextmanager
    def jobs(self) -> Iterator[Jobs]:
        """Open the job queue."""
        jobs = Jobs(self.database, self.settings)
        try:
            yield jobs
        finally:
            jobs.close()


def create_data_folder(settings: Settings) -> None:
    """Create the data folder if it is missing, and check that files can be written and locked.

    Raises:
        Unavailable: It can't be created, or not be used.
    """
    folder = settings.data
    try:
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        is_private = make_private(folder)
    except OSError as error:
        raise Unavailable(
            f"The data folder {folder} can't be created: {error.strerror}. Choose another"
            " with TRIL_DATA."
        ) from error
    if not is_private:
        errors.print(
            f"Other users of this machine can read the data folder {folder}. If they are not to:"
            f" {shlex.join(['chmod', '-R', 'go-rwx', str(folder)])}",
            style="yellow",
        )
    try:
        probe = tempfile.TemporaryFile(dir=folder)  # noqa: SIM115
    except OSError as error:
        raise Unavailable(
            f"Nothing can be written in the data folder {folder}: {error.strerror}. Let this user"
            " write there, or choose another folder with TRIL_DATA."
        ) from error
    with probe:
        try:
            # Of both kinds: SQLite and the workers use one, `tril up` the other.
            fcntl.lockf(probe, fcntl.LOCK_EX | fcntl.LOCK_NB)
            fcntl.flock(probe, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as error:
            raise Unavailable(
                f"The file system of the data folder {folder} has no locks ({error.strerror}), and"
                " without them databases are damaged. Choose a folder on a disk of this machine"
                " with TRIL_DATA."
            ) from error


def migrate_databases(settings: Settings, *, keep_copy: bool = True) -> None:
    """Migrate the application's database and set up the built-in behaviours and the queue.

    Args:
        settings: Name the databases.
        keep_copy: Whether a database of an earlier version is copied first.

    Raises:
        Unavailable: The data folder is not writable, the database is of a newer version, or it
            can't be copied.
    """
    create_data_folder(settings)
    database = create_database(settings.application_url)
    try:
        upgrade(database, settings.upgrade_copies if keep_copy else None)
    except CopyFailed as error:
        raise Unavailable(
            f"{error} The database is of an earlier version of Tril and was not changed. To upgrade"
            " it without a copy: tril migrate --without-copy"
        ) from error
    finally:
        database.close()
    prepare_queue(settings)


@contextmanager
def open_workspace() -> Iterator[Workspace]:
    """Open the data folder, migrating its databases, with ``readable_errors``."""
    with readable_errors():
        settings = read_settings()
        migrate_databases(settings)
        database = create_database(settings.application_url)
        try:
            yield Workspace(settings, database)
        finally:
            database.close()


def find_behaviour(session: Session, name: str) -> BehaviourRow:
    """Find a behaviour by its short name or id; raises NotFound."""
    if name.isdecimal() and len(name) < 10:
        return behaviours.get(session, int(name))
    return behaviours.by_slug(session, name)
