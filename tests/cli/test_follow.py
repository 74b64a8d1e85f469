"""Following a run with a worker that may fail, as ``tril train`` does."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import psutil
import pytest

from cli.follow import MAX_WORKER_FAILURES, follow, standby_worker
from cli.workspace import Workspace
from testsupport.waiting import wait_until
from testsupport.workplace import Workplace
from tril.errors import Unavailable
from tril.store.models import RunStatus

FAILING = (sys.executable, "-c", "raise SystemExit(3)")


def _opened(workplace: Workplace) -> Workspace:
    return Workspace(workplace.settings, workplace.database)


def test_following_ends_when_the_worker_keeps_failing(workplace: Workplace) -> None:
    run_id = workplace.make_run()
    with (
        standby_worker(_opened(workplace), FAILING) as worker,
        pytest.raises(Unavailable, match=rf"{MAX_WORKER_FAILURES} times.*3.*worker\.log"),
    ):
        follow(_opened(workplace), run_id, worker)
    assert workplace.run(run_id).status == RunStatus.QUEUED


FAILS_ONCE = """
import sys
from pathlib import Path
from tril.store.database import create_database
from tril.store.training import runs
marker = Path(sys.argv[1])
if not marker.exists():
    marker.touch()
    raise SystemExit(3)
database = create_database(sys.argv[3])
with database.writing() as session:
    runs.request_cancel(session, sys.argv[2])
"""


def test_a_worker_that_ends_is_replaced(workplace: Workplace, tmp_path: Path) -> None:
    run_id = workplace.make_run()
    arguments = (str(tmp_path / "failed"), run_id, workplace.settings.application_url)
    command = (sys.executable, "-c", FAILS_ONCE, *arguments)
    with standby_worker(_opened(workplace), command) as worker:
        assert follow(_opened(workplace), run_id, worker).status == RunStatus.CANCELLED


WAITING = """
import time
from cli.follow import standby_worker
from cli.workspace import open_workspace
with open_workspace() as workspace, standby_worker(workspace) as worker:
    worker.ensure()
    time.sleep(600)
"""


def test_a_worker_started_for_a_command_ends_when_the_command_is_killed(data_folder: Path) -> None:
    command = subprocess.Popen([sys.executable, "-c", WAITING], stderr=subprocess.DEVNULL)
    log = data_folder / "logs" / "worker.log"
    try:
        wait_until(lambda: log.exists() and "waits for runs" in log.read_text())
        [worker] = psutil.Process(command.pid).children()
    finally:
        command.kill()
        command.wait()
    wait_until(lambda: not worker.is_running())
