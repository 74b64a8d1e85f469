"""A worker that claims a run and then does nothing until it is killed; for tests of delivery."""

from __future__ import annotations

import sys
import time
from pathlib import Path

from dbos import DBOS

from tril.jobs import APPLICATION, QUEUE, VERSION, WORKFLOW
from tril.jobs.queue import serializer
from tril.settings import Settings
from tril.store.database import create_database
from tril.store.training import leases


def main(folder: str, name: str) -> None:
    """Lease runs as the worker ``name`` of the data folder; prints each claimed run's id."""
    settings = Settings(data=Path(folder))
    database = create_database(settings.application_url)

    @DBOS.workflow(name=WORKFLOW)
    def train(run_id: str) -> None:
        with database.writing() as session:
            claim = leases.claim(session, run_id, name, {})
        if claim is None:
            print("nothing to do", run_id, flush=True)
            return
        print("claimed", run_id, flush=True)
        while True:
            time.sleep(1)

    DBOS(
        config={
            "name": APPLICATION,
            "system_database_url": settings.queue_url,
            "executor_id": name,
            "application_version": VERSION,
            "serializer": serializer(),
            "log_level": "WARNING",
        }
    )
    DBOS.listen_queues([QUEUE])
    DBOS.launch()
    while True:
        time.sleep(1)


if __name__ == "__main__":
    main(*sys.argv[1:])
