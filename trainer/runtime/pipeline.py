"""Takes a run through its stages, across crashes of this process.

The run's row says which stages are finished; a stage that is not is begun again, and goes on from
its own checkpoint if it has one. So it does no harm when the queue delivers a run twice.
"""

from __future__ import annotations

import errno
import logging
import shutil
import threading
import traceback
from collections.abc import Callable
from datetime import UTC, datetime
from functools import partial
from pathlib import Path

import torch
from sqlalchemy.orm import Session

from trainer.nn.devices import free_memory
from trainer.progress import RunCancelled
from trainer.runtime.context import RunContext, StageProgress, WorkerStopping
from trainer.runtime.priority import learning_threads
from trainer.runtime.run_data import RunData
from trainer.runtime.stages import STAGE_WORK
from trainer.runtime.versions import versions
from tril.errors import TrilError
from tril.files.artifact_store import DISK_FULL, ArtifactStore
from tril.jobs import RunEta
from tril.recipes import recipe_from_dict
from tril.settings import Settings
from tril.stages import Stage, stages_of
from tril.store import behaviours
from tril.store.database import Database
from tril.store.models import RunStatus
from tril.store.training import leases, runs
from tril.store.training.leases import Lease, LeaseLost

log = logging.getLogger(__name__)

FINISHED = "finished"
LEASE_LOST = "leased to another worker"
GIVEN_BACK = "given back to the queue"
RunStage = Callable[[str, str], str]
"""(run id, stage) -> FINISHED, or how the run ended or left this worker."""


class Pipeline:
    """Runs the stages of runs, one run at a time.

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
        self._threads = learning_threads(settings.learning_threads)
        self._at_work: dict[str, RunData] = {}

    @property
    def run_ids(self) -> list[str]:
        """The runs at work, at most one."""
        return list(self._at_work)

    def beat(self, session: Session) -> None:
        """Write the heartbeat of the runs at work."""
        for data in list(self._at_work.values()):
            leases.beat(session, data.context.lease)

    def sweep(self) -> None:
        """Remove the scratch folders of runs that are done or deleted."""
        folders = self._settings.data / "runs"
        if not folders.is_dir():
            return
        with self._database.reading() as session:
            past = runs.past_resuming(session, [folder.name for folder in folders.iterdir()])
        for run_id in past:
            shutil.rmtree(folders / run_id, ignore_errors=True)

    def train(self, run_id: str, run_stage: RunStage) -> str:
        """Lease a run and take it through its stages.

        Args:
            run_id: The run.
            run_stage: Runs one stage, by way of ``self.run_stage``.

        Returns:
            How it ended, for the log.
        """
        if self._stopping.is_set():
            return "left in the queue"
        with self._database.writing() as session:
            lease = leases.acquire(session, run_id, self._worker, versions())
        if lease is None:
            log.info("Run %s: nothing to do.", run_id)
            return "nothing to do"
        try:
            context = self._context(lease)
        except Exception as problem:
            # E.g. a recipe of another version, or the behaviour was deleted.
            log.exception("Run %s can't be started.", run_id)
            return self._end(lease, RunStatus.FAILED, failure_message("start", problem, run_id))
        self._at_work[run_id] = RunData(context)
        try:
            result = self._run_stages(context, run_stage)
        finally:
            del self._at_work[run_id]
            free_memory()
        log.info("Run %s: %s.", run_id, result)
        return result

    def _run_stages(self, context: RunContext, run_stage: RunStage) -> str:
        stages = stages_of(context.run.example)
        for stage in stages:
            result = run_stage(context.run_id, stage)
            if result != FINISHED:
                return result
        if any(stage not in context.run.finished_stages for stage in stages):
            # The queue remembers a stage as done that the row does not: the row is the truth.
            return self._leave(context.lease, leases.release, GIVEN_BACK)
        result = self._end(context.lease, RunStatus.DONE)
        if result == RunStatus.DONE:
            shutil.rmtree(scratch_folder(self._settings, context.run_id), ignore_errors=True)
        return result

    def run_stage(self, run_id: str, name: str) -> str:
        """Run one stage of the run at work; however it ends is written to the run."""
        data, stage = self._at_work[run_id], Stage(name)
        lease = data.context.lease
        try:
            if stage not in data.context.run.finished_stages:
                self._work(data, stage)
            run = data.context.run
            check = run.outcome.check if stage is Stage.CHECK else None
            if check is not None and not check.passed and not run.go_on_anyway:
                return self._end(lease, RunStatus.STOPPED, check.advice)
            return FINISHED
        except LeaseLost:
            # The queue's record of this stage will be refused, too, and end the job here.
            log.info("Run %s: %s.", run_id, LEASE_LOST)
            return LEASE_LOST
        except WorkerStopping:
            return self._leave(lease, leases.release, GIVEN_BACK)
        except RunCancelled:
            return self._end(lease, RunStatus.CANCELLED)
        except Exception as problem:
            # The one catch-all: the person is told and the worker lives on.
            self._write_log(run_id, stage)
            log.exception("Run %s: stage %s failed.", run_id, stage)
            return self._end(lease, RunStatus.FAILED, failure_message(stage, problem, run_id))

    def _work(self, data: RunData, stage: Stage) -> None:
        context = data.context
        log.info("Run %s: stage %s begins.", context.run_id, stage)
        # torch counts threads for each thread separately.
        torch.set_num_threads(self._threads)
        context.check_cancelled()
        progress = StageProgress(context, stage)
        progress.report()
        found = STAGE_WORK[stage](data, progress)
        seconds = progress.seconds()
        context.finish_stage(stage, seconds, found)
        log.info("Run %s: stage %s is finished after %.1f s.", context.run_id, stage, seconds)

    def _context(self, lease: Lease) -> RunContext:
        with self._database.reading() as session:
            run = runs.get(session, lease.run_id)
            return RunContext(
                lease=lease,
                run=run,
                behaviour=behaviours.as_behaviour(behaviours.get(session, run.behaviour_id)),
                recipe=recipe_from_dict(run.recipe),
                database=self._database,
                artifacts=self._artifacts,
                folder=own_scratch_folder(scratch_folder(self._settings, run.id), lease.epoch),
                settings=self._settings,
                eta=RunEta.of(session, run),
                threads=self._threads,
                stopping=self._stopping,
            )

    def _end(self, lease: Lease, status: RunStatus, message: str = "") -> str:
        return self._leave(lease, partial(leases.end, status=status, message=message), status)

    def _leave(self, lease: Lease, write: Callable[[Session, Lease], None], result: str) -> str:
        try:
            with self._database.writing() as session:
                write(session, lease)
        except LeaseLost:
            return LEASE_LOST
        return result

    def _write_log(self, run_id: str, stage: str) -> None:
        path = self._settings.data / "logs" / "runs" / f"{run_id}.log"
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            with path.open("a") as file:
                file.write(f"{datetime.now(UTC).isoformat()} stage {stage}\n")
                traceback.print_exc(file=file)
        except OSError as problem:
            log.warning("The log of run %s could not be written: %s", run_id, problem)


def failure_message(stage: str, problem: BaseException, run_id: str) -> str:
    """Return what a person reads about a failed stage: what went wrong and what to do."""
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


def own_scratch_folder(root: Path, epoch: int) -> Path:
    """Return the scratch folder of a lease, with what the lease before left in its own.

    The earlier folder is renamed, so that a worker which has lost the run without knowing finds
    its folder gone and can't replace the checkpoints of the one that has it now.
    """
    root.mkdir(parents=True, exist_ok=True)
    own = root / str(epoch)
    if own.exists():
        return own
    earlier = sorted(
        (int(path.name) for path in root.iterdir() if path.name.isdigit()), reverse=True
    )
    if earlier:
        (root / str(earlier[0])).rename(own)
    else:
        own.mkdir()
    for number in earlier[1:]:
        shutil.rmtree(root / str(number), ignore_errors=True)
    return own
