"""A worker that leases a run and then does nothing until it is killed; for tests of delivery."""

from __future__ import annotations

import sys
import time
from pathlib import Path

from dbos import DBOS

from testsupport.databases import settings_on
from tril.jobs import QUEUES, WORKFLOW, executor_config
from tril.store import processes
from tril.store.database import create_database
from tril.store.training import leases


def main(folder: str, name: str) -> None:
    """Lease runs as the worker ``name`` of the data folder; prints each leased run's id."""
    settings = settings_on(Path(folder))
    database = create_database(settings.application_url)
    with database.writing() as session:
        processes.beat(session, name, "worker", {})

    @DBOS.workflow(name=WORKFLOW)
    def train(run_id: str) -> None:
        with database.writing() as session:
            lease = leases.acquire(session, run_id, name)
        if lease is None:
            print("nothing to do", run_id, flush=True)
            return
        print("leased", run_id, flush=True)
        while True:
            time.sleep(1)

    DBOS(config=executor_config(settings, name))
    DBOS.listen_queues(list(QUEUES.values()))
    DBOS.launch()
    while True:
        time.sleep(1)


if __name__ == "__main__":
    main(*sys.argv[1:])
