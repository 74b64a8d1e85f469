"""Takes a run through its stages, whatever happens to this process on the way.

The run's row says which stages are finished; a stage that is not is begun again, and goes on from
its own checkpoint if it has one. So it does no harm when the queue brings a run twice.
"""

from __future__ import annotations

import errno
import logging
import shutil
import threading
import traceback
from collections.abc import Callable
from datetime import UTC, datetime
from pathlib import Path

import torch
from sqlalchemy.orm import Session

from trainer.nn.devices import free_memory
from trainer.progress import RunCancelled
from trainer.runtime.context import RunContext, StageProgress, WorkerStopping
from trainer.runtime.run_data import RunData
from trainer.runtime.stages import STAGE_WORK
from trainer.runtime.throttle import Throttle, learning_threads
from trainer.runtime.versions import versions
from tril.errors import TrilError
from tril.files.artifact_store import DISK_FULL, ArtifactStore
from tril.jobs import RunEta
from tril.recipes import recipe_from_dict
from tril.settings import Settings
from tril.stages import Stage, stages_of
from tril.store import behaviours
from tril.store.database import Database
from tril.store.models import RunRow, RunStatus
from tril.store.training import leases, runs
from tril.store.training.leases import Lease, LeaseLost

log = logging.getLogger(__name__)

FINISHED = "finished"
TAKEN_OVER = "taken over by another worker"
Perform = Callable[[str, str], str]
"""(run id, stage) -> FINISHED, or how the run ended or left this worker."""


class RunStopped(Exception):
    """The check of the ranking was not passed; the message says what is confused."""


class Pipeline:
    """A worker's way of doing runs, one at a time.

    Args:
        database: The application's database.
        settings: Settings of the process.
        worker: Name of the worker, which no other living process has.
        stopping: Set when the worker is to stop.
    """

    def __init__(
        self, database: Database, settings: Settings, worker: str, stopping: threading.Event
    ) -> None:
        self._database = database
        self._settings = settings
        self._worker = worker
        self._stopping = stopping
        self._artifacts = ArtifactStore(settings.artifact_root)
        self._courtesy = Throttle(learning_threads(settings.learning_threads))
        self._at_work: dict[str, RunData] = {}

    @property
    def run_ids(self) -> list[str]:
        """The runs at work, at most one."""
        return list(self._at_work)

    def beat(self, session: Session) -> None:
        """Note on the runs at work that their worker lives."""
        for data in list(self._at_work.values()):
            leases.beat(session, data.context.claim)

    def sweep(self) -> None:
        """Remove the scratch folders of runs that nothing will go on with."""
        folders = self._settings.data / "runs"
        if not folders.is_dir():
            return
        with self._database.reading() as session:
            past = runs.past_resuming(session, [folder.name for folder in folders.iterdir()])
        for run_id in past:
            shutil.rmtree(folders / run_id, ignore_errors=True)

    def train(self, run_id: str, perform: Perform) -> str:
        """Lease a run and take it through its stages.

        Args:
            run_id: The run.
            perform: Does one stage, by way of ``self.perform``.

        Returns:
            How it ended, for the log.
        """
        if self._stopping.is_set():
            return "left in the queue"
        with self._database.writing() as session:
            claim = leases.claim(session, run_id, self._worker, versions())
        if claim is None:
            log.info("Run %s: nothing to do.", run_id)
            return "nothing to do"
        try:
            data, stages = self._prepare(claim)
        except Exception as problem:
            # E.g. a recipe of another version, or the behaviour was deleted.
            log.exception("Run %s can't be begun.", run_id)
            return self._end(claim, RunStatus.FAILED, explain("start", problem, run_id))
        self._at_work[run_id] = data
        try:
            how = self._go_through(data, stages, perform)
        finally:
            del self._at_work[run_id]
            free_memory()
        log.info("Run %s: %s.", run_id, how)
        return how

    def _go_through(self, data: RunData, stages: tuple[Stage, ...], perform: Perform) -> str:
        context = data.context
        for stage in stages:
            how = perform(context.run_id, stage)
            if how != FINISHED:
                return how
        if any(stage not in context.finished for stage in stages):
            # The queue remembers a stage as done that the row does not: the row is the truth.
            return self._leave(context.claim, leases.release, "given back to the queue")
        how = self._end(context.claim, RunStatus.DONE, "")
        if how == RunStatus.DONE:
            shutil.rmtree(scratch_folder(self._settings, context.run_id), ignore_errors=True)
        return how

    def perform(self, run_id: str, stage: str) -> str:
        """Do one stage of the run at work; every way it can end is noted on the run."""
        data = self._at_work[run_id]
        try:
            if stage not in data.context.finished:
                self._do(data, Stage(stage))
            if stage == Stage.CHECK:
                stop_if_confused(data.context)
            return FINISHED
        except LeaseLost:
            # The queue's record of this stage will be refused, too, and end the job here.
            log.info("Run %s: %s.", run_id, TAKEN_OVER)
            return TAKEN_OVER
        except WorkerStopping:
            return self._leave(data.context.claim, leases.release, "given back to the queue")
        except RunCancelled:
            return self._end(data.context.claim, RunStatus.CANCELLED, "")
        except RunStopped as stopped:
            return self._end(data.context.claim, RunStatus.STOPPED, str(stopped))
        except Exception as problem:
            # The one catch-all: whatever it is, the person is told and the worker lives on.
            self._write_log(run_id, stage)
            log.exception("Run %s: stage %s failed.", run_id, stage)
            return self._end(data.context.claim, RunStatus.FAILED, explain(stage, problem, run_id))

    def _do(self, data: RunData, stage: Stage) -> None:
        context = data.context
        log.info("Run %s: stage %s begins.", context.run_id, stage)
        self._courtesy.begin()
        context.check_cancelled()
        progress = StageProgress(context, stage)
        progress.report()
        outcome = STAGE_WORK[stage](data, progress)
        seconds = progress.seconds()
        context.finish_stage(stage, seconds, outcome)
        log.info("Run %s: stage %s is finished after %.1f s.", context.run_id, stage, seconds)

    def _prepare(self, claim: Lease) -> tuple[RunData, tuple[Stage, ...]]:
        with self._database.reading() as session:
            row = runs.get(session, claim.run_id)
            return RunData(self._context(session, row, claim)), stages_of(row.example)

    def _context(self, session: Session, row: RunRow, claim: Lease) -> RunContext:
        return RunContext(
            claim=claim,
            behaviour_id=row.behaviour_id,
            behaviour=behaviours.as_behaviour(behaviours.get(session, row.behaviour_id)),
            recipe=recipe_from_dict(row.recipe),
            steps=row.steps,
            training_seed=row.training_seed,
            outcome=row.outcome,
            go_on_anyway=row.go_on_anyway,
            snapshot=row.snapshot,
            finished=dict(row.finished_stages),
            database=self._database,
            artifacts=self._artifacts,
            folder=take_over_folder(scratch_folder(self._settings, row.id), claim.epoch),
            settings=self._settings,
            forecast=RunEta.of(session, row),
            courtesy=self._courtesy,
            stopping=self._stopping,
            example_kind=row.example_kind,
        )

    def _end(self, claim: Lease, status: RunStatus, message: str) -> str:
        def end(session: Session, claim: Lease) -> None:
            leases.end(session, claim, status, message)

        return self._leave(claim, end, str(status))

    def _leave(self, claim: Lease, write: Callable[[Session, Lease], None], how: str) -> str:
        try:
            with self._database.writing() as session:
                write(session, claim)
        except LeaseLost:
            return TAKEN_OVER
        return how

    def _write_log(self, run_id: str, stage: str) -> None:
        path = log_file(self._settings, run_id)
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            with path.open("a") as file:
                file.write(f"{datetime.now(UTC).isoformat()} stage {stage}\n")
                traceback.print_exc(file=file)
        except OSError as problem:
            log.warning("The log of run %s could not be written: %s", run_id, problem)


def stop_if_confused(context: RunContext) -> None:
    """Stop the run here if its ranking was not understood and nobody said to go on anyway."""
    check = context.outcome.check
    if check is not None and not check.passed and not context.go_on_anyway:
        raise RunStopped(check.advice)


def explain(stage: str, problem: BaseException, run_id: str) -> str:
    """Say to a person what went wrong in a stage, and what to do."""
    if isinstance(problem, TrilError):
        return str(problem)
    if isinstance(problem, OSError) and problem.errno in {errno.ENOSPC, errno.EDQUOT}:
        return DISK_FULL
    is_full = isinstance(problem, (MemoryError, torch.OutOfMemoryError))
    if is_full or "not enough memory" in str(problem):
        return (
            "There was not enough memory. Close other programs or choose fewer games at a time, "
            "then resume; what was learned so far is kept."
        )
    return (
        f"Something unexpected went wrong in the stage \u201c{stage}\u201d: "
        f"{type(problem).__name__}: {problem}. The details are in logs/runs/{run_id}.log in the "
        "data folder. Resume to try again from the last checkpoint."
    )


def scratch_folder(settings: Settings, run_id: str) -> Path:
    """Return the folder of a run's checkpoints on this machine."""
    return settings.data / "runs" / run_id


def log_file(settings: Settings, run_id: str) -> Path:
    """Return the file that holds the tracebacks of a run's failures."""
    return settings.data / "logs" / "runs" / f"{run_id}.log"


def take_over_folder(root: Path, epoch: int) -> Path:
    """Give a claim its own scratch folder, with what an earlier claim left in its.

    The earlier folder is renamed, so a worker that has lost the run without knowing finds its
    folder gone and can't disturb the checkpoints of the one that has it now.
    """
    root.mkdir(parents=True, exist_ok=True)
    mine = root / str(epoch)
    if mine.exists():
        return mine
    earlier = sorted(
        (int(path.name) for path in root.iterdir() if path.name.isdigit()), reverse=True
    )
    if earlier:
        (root / str(earlier[0])).rename(mine)
    else:
        mine.mkdir()
    for number in earlier[1:]:
        shutil.rmtree(root / str(number), ignore_errors=True)
    return mine
