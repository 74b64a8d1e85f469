"""Following a run on the terminal, with a worker of its own where none is running."""

from __future__ import annotations

import subprocess
from collections.abc import Iterator
from contextlib import contextmanager

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
from cli.supervision.supervisor import child_environment, tril_command
from cli.workspace import Workspace
from tril.jobs import overall_progress
from tril.store import processes
from tril.store.models import RunRow, RunStatus

WORKER_STOP_TIMEOUT_S = 30.0

STAGE_NAMES = {
    "demonstrations": "making demonstrations",
    "trajectories": "replaying recordings",
    "reward": "learning the reward",
    "check": "checking the ranking",
    "clone": "cloning",
    "imitator": "training the imitator",
    "evaluation": "playing evaluation games",
    "attention": "drawing attention maps",
}


class _Remaining(TextColumn):
    """What the worker says is left, not what the bar's own speed suggests."""

    def __init__(self) -> None:
        super().__init__("")

    def render(self, task: ProgressTask) -> Text:
        remaining_s = task.fields.get("remaining_s")
        return Text("" if remaining_s is None else f"{duration(remaining_s)} left", style="cyan")


@contextmanager
def worker_at_hand(workspace: Workspace) -> Iterator[None]:
    """Make sure that a worker runs: one that is there, or one started for the time being."""
    with workspace.database.reading() as session:
        present = processes.is_kind_alive(session, "worker")
    if present:
        yield
        return
    errors.print("No worker is running; one is started for this run.")
    log = workspace.settings.data / "logs" / "worker.log"
    log.parent.mkdir(parents=True, exist_ok=True)
    with log.open("ab") as output:
        worker = subprocess.Popen(
            tril_command("worker"), env=child_environment(), stdout=output, stderr=output
        )
    try:
        yield
    finally:
        worker.terminate()
        try:
            worker.wait(WORKER_STOP_TIMEOUT_S)
        except subprocess.TimeoutExpired:
            worker.kill()
            worker.wait()


def follow(workspace: Workspace, run_id: str) -> RunRow:
    """Show a run's progress until it is over; returns its final row.

    Ctrl-C stops following, not the run.
    """
    columns = (
        TextColumn("{task.description:<26}"),
        BarColumn(),
        TaskProgressColumn(),
        TimeElapsedColumn(),
        _Remaining(),
    )
    row: RunRow | None = None
    with workspace.jobs() as jobs, Progress(*columns, console=console) as progress:
        whole = progress.add_task("the whole run", total=1.0)
        stage_tasks: dict[str, TaskID] = {}
        for row in jobs.follow(run_id):
            progress.update(
                whole,
                completed=overall_progress(row),
                remaining_s=row.remaining_s,
            )
            if row.stage not in STAGE_NAMES:
                continue
            for name, task in stage_tasks.items():
                if name != row.stage:
                    progress.update(task, completed=1.0)
            if row.stage not in stage_tasks:
                stage_tasks[row.stage] = progress.add_task(STAGE_NAMES[row.stage], total=1.0)
            progress.update(stage_tasks[row.stage], completed=row.stage_done)
    assert row is not None
    return row


def say_how_it_ended(row: RunRow) -> bool:
    """Print a run's end; returns whether it is done."""
    if row.status == RunStatus.DONE:
        return True
    errors.print(f"[bold]The run is {row.status}.[/] {row.message}")
    return False


def duration(seconds: float) -> str:
    """A time for people, e.g. "2 min 5 s"."""
    minutes, rest = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    if hours:
        return f"{hours} h {minutes} min"
    return f"{minutes} min {rest} s" if minutes else f"{rest} s"
