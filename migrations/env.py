"""Run by Alembic: connects it with the database and the models."""

from typing import Any, Literal

from alembic import context
from sqlalchemy import Connection

from tril.settings import Settings
from tril.store.database import create_database
from tril.store.models import Base, UTCDateTime


def _render(kind: str, item: Any, _context: Any) -> str | Literal[False]:
    # Old revisions must not depend on what the models' types become.
    if kind == "type" and isinstance(item, UTCDateTime):
        return "sa.DateTime(timezone=True)"
    return False


def _migrate(connection: Connection) -> None:
    context.configure(
        connection=connection,
        target_metadata=Base.metadata,
        # SQLite can't alter a table; Alembic then writes it anew.
        render_as_batch=connection.dialect.name == "sqlite",
        render_item=_render,
        compare_type=True,
        compare_server_default=True,
        transactional_ddl=True,
    )
    with context.begin_transaction():
        context.run_migrations()


given = context.config.attributes.get("connection")
if given is not None:
    _migrate(given)
else:
    database = create_database(Settings().application_url)
    try:
        with database.upgrading() as connection:
            _migrate(connection)
    finally:
        database.close()
