"""Follow a run on the terminal, with a standby worker."""

from __future__ import annotations

import subprocess
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager

import typer
from rich.progress import (
    BarColumn,
    Progress,
    TaskID,
    TaskProgressColumn,
    TextColumn,
    TimeElapsedColumn,
)
from rich.progress import Task as ProgressTask
from rich.text import Text

from cli.output import console, errors
from cli.supervision.orphans import child_environment
from cli.supervision.supervisor import tril_command
from cli.workspace import Workspace
from tril.errors import Unavailable
from tril.jobs import overall_progress
from tril.stages import Stage
from tril.store import processes
from tril.store.models import RunRow, RunStatus
from tril.store.training import runs

POLL_S = 0.5
WORKER_STOP_TIMEOUT_S = 30.0
MAX_WORKER_FAILURES = 3


class _EtaColumn(TextColumn):
    """The worker's estimate of the remaining time."""

    def __init__(self) -> None:
        super().__init__("")

    def render(self, task: ProgressTask) -> Text:
        remaining_s = task.fields.get("remaining_s")
        return Text("" if remaining_s is None else f"{duration(remaining_s)} left", style="cyan")


class StandbyWorker:
    """Runs a worker while no other one does.

    Args:
        workspace: The opened data folder.
        command: The worker's command line.
    """

    def __init__(self, workspace: Workspace, command: Sequence[str]) -> None:
        self._workspace = workspace
        self._command = command
        self._process: subprocess.Popen[bytes] | None = None
        self._n_failures = 0
        self._log = workspace.settings.data / "logs" / "worker.log"

    def ensure(self) -> None:
        """Start a worker if none runs.

        Raises:
            Unavailable: The standby worker has ended MAX_WORKER_FAILURES times.
        """
        if self._process is not None:
            exit_code = self._process.poll()
            if exit_code is None:
                return
            self._process = None
            self._n_failures += 1
            if self._n_failures == MAX_WORKER_FAILURES:
                raise Unavailable(
                    f"The worker ended {self._n_failures} times, last with exit code {exit_code}."
                    f" See {self._log}. The run stays in the queue."
                )
        with self._workspace.database.reading() as session:
            if processes.is_kind_alive(session, "worker"):
                return
        errors.print("No worker is running; starting one for this command.")
        self._log.parent.mkdir(parents=True, exist_ok=True)
        with self._log.open("ab") as output:
            self._process = subprocess.Popen(
                self._command, env=child_environment(), stdout=output, stderr=output
            )

    def stop(self) -> None:
        """Stop the standby worker, if any: SIGTERM, then SIGKILL."""
        if self._process is None:
            return
        self._process.terminate()
        try:
            self._process.wait(WORKER_STOP_TIMEOUT_S)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()


@contextmanager
def standby_worker(
    workspace: Workspace, command: Sequence[str] | None = None
) -> Iterator[StandbyWorker]:
    """Provide a worker for the duration of a block; call its ``ensure`` while waiting."""
    worker = StandbyWorker(workspace, command or tril_command("worker"))
    try:
        yield worker
    finally:
        worker.stop()


def follow(workspace: Workspace, run_id: str, worker: StandbyWorker) -> RunRow:
    """Show a run's progress until it is over.

    Ctrl-C stops following, not the run.

    Args:
        workspace: The opened data folder.
        run_id: The run.
        worker: Executes the run if no other worker does.

    Returns:
        The run's final row.

    Raises:
        NotFound: There is no such run.
        Unavailable: No worker can be kept running.
    """
    columns = (
        TextColumn("{task.description:<26}", markup=False),
        BarColumn(),
        TaskProgressColumn(),
        TimeElapsedColumn(),
        _EtaColumn(),
    )
    with Progress(*columns, console=console) as progress:
        run_task = progress.add_task("the whole run", total=1.0)
        stage_tasks: dict[str, TaskID] = {}
        while True:
            with workspace.database.reading() as session:
                row = runs.get(session, run_id)
                progress_share = overall_progress(session, row)
            progress.update(run_task, completed=progress_share, remaining_s=row.remaining_s)
            if row.stage:
                for name, task in stage_tasks.items():
                    if name != row.stage:
                        progress.update(task, completed=1.0)
                if row.stage not in stage_tasks:
                    label = Stage(row.stage).label
                    stage_tasks[row.stage] = progress.add_task(label, total=1.0)
                progress.update(stage_tasks[row.stage], completed=row.stage_done)
            if RunStatus(row.status).is_over:
                return row
            worker.ensure()
            time.sleep(POLL_S)


def follow_to_end(workspace: Workspace, run_id: str) -> RunRow:
    """Follow a run with a standby worker; print its outcome and exit unless it is done.

    Raises:
        typer.Exit: The run was cancelled, stopped or failed.
    """
    with standby_worker(workspace) as worker:
        row = follow(workspace, run_id, worker)
    if row.status != RunStatus.DONE:
        errors.print(Text.assemble((f"The run is {row.status}.", "bold"), f" {row.message}"))
        raise typer.Exit(1)
    return row


def duration(seconds: float) -> str:
    """Format a duration, e.g. "2 min 5 s"."""
    minutes, seconds_left = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    if hours:
        return f"{hours} h {minutes} min"
    return f"{minutes} min {seconds_left} s" if minutes else f"{seconds_left} s"
