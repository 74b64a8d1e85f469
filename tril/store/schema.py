"""The database's schema: upgraded to this version, refused if it is of another one."""

from __future__ import annotations

import logging
from functools import cache
from pathlib import Path

from alembic import command
from alembic.config import Config
from alembic.runtime.migration import MigrationContext
from alembic.script import ScriptDirectory
from sqlalchemy.exc import OperationalError

from tril.errors import Unavailable
from tril.store import behaviours, players
from tril.store.copies import copy_before_upgrade
from tril.store.database import Database

_MIGRATIONS = Path(__file__).resolve().parents[2] / "migrations"


def upgrade(database: Database, copies: Path | None = None) -> None:
    """Upgrade a database to this version and add what is built-in; harmless when repeated.

    The schema changes in one transaction, so a failed upgrade leaves the database as it was.

    Args:
        database: The database.
        copies: Folder in which a copy is kept of a database of an earlier version; None for none.

    Raises:
        Unavailable: The database is of a newer version of Tril.
        CopyFailed: It can't be copied; it is left as it was.
    """
    config = alembic_config()
    with database.upgrading() as connection:
        present = MigrationContext.configure(connection).get_current_revision()
        _refuse_newer(present)
        is_old = present not in {None, schema_revision()}
        if is_old and copies is not None:
            assert present is not None
            copy_before_upgrade(database.engine, present, copies)
        config.attributes["connection"] = connection
        command.upgrade(config, "head")
    with database.writing() as session:
        players.seed_owner(session)
        behaviours.seed_built_in(session)


def check_schema(database: Database) -> None:
    """Refuse a database of another version.

    Raises:
        Unavailable: It is older, newer, empty, or can't be reached.
    """
    try:
        with database.engine.connect() as connection:
            present = MigrationContext.configure(connection).get_current_revision()
    except OperationalError as error:
        raise Unavailable(f"The database can't be reached: {error.orig}.") from error
    _refuse_newer(present)
    if present != schema_revision():
        was = "empty" if present is None else f"of an older version of Tril ({present})"
        raise Unavailable(
            f"The database is {was}. Bring it up to date with `tril migrate`; `tril up` and "
            "`make run` do so by themselves. Nothing is lost."
        )


def schema_revision() -> str:
    """Return the revision of the schema that this version works on."""
    revision = _scripts(_MIGRATIONS).get_current_head()
    assert revision is not None
    return revision


def alembic_config() -> Config:
    """Return Alembic's configuration."""
    # Otherwise it logs two lines each time, even if nothing is to be done.
    logging.getLogger("alembic.runtime.migration").setLevel(logging.WARNING)
    config = Config()
    # ConfigParser takes percent signs for interpolation.
    config.set_main_option("script_location", str(_MIGRATIONS).replace("%", "%%"))
    return config


def known_revisions() -> set[str]:
    """Return the revisions of this version's schema and of earlier ones."""
    return {script.revision for script in _scripts(_MIGRATIONS).walk_revisions()}


@cache
def _scripts(_folder: Path) -> ScriptDirectory:
    """Read the migrations, which takes 50 ms, once for each folder."""
    return ScriptDirectory.from_config(alembic_config())


def _refuse_newer(revision: str | None) -> None:
    if revision is not None and revision not in known_revisions():
        raise Unavailable(
            f"The database was written by a newer version of Tril (revision {revision}), which "
            "this one can't read. Update Tril, or choose another data folder with TRIL_DATA."
        )
