"""What the commands work on: the databases of the data folder, opened and checked."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

from sqlalchemy.orm import Session

from cli.output import plain_errors
from tril.jobs import Jobs, prepare_queue
from tril.settings import Settings
from tril.store import behaviours
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


def bring_up_to_date(settings: Settings) -> None:
    """Upgrade the application's database, fill in what comes ready, and set up the queue's."""
    database = create_database(settings.application_url)
    try:
        upgrade(database)
    finally:
        database.close()
    prepare_queue(settings)


@contextmanager
def open_workspace() -> Iterator[Workspace]:
    """Open the data folder, its databases brought up to date; errors end in plain words."""
    settings = Settings()
    with plain_errors():
        bring_up_to_date(settings)
        database = create_database(settings.application_url)
        try:
            yield Workspace(settings, database)
        finally:
            database.close()


def find_behaviour(session: Session, name: str) -> BehaviourRow:
    """Look a behaviour up by its short name or its number."""
    if name.isdigit():
        return behaviours.get(session, int(name))
    return behaviours.by_slug(session, name)
