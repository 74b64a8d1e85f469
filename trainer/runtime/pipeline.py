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
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from datetime import UTC, datetime
from functools import partial

import torch
from sqlalchemy.exc import DBAPIError
from sqlalchemy.orm import Session

from trainer.nn.checkpoints import CheckpointDamaged
from trainer.nn.devices import free_memory
from trainer.progress import RunCancelled
from trainer.runtime.context import RunContext, StageProgress, WorkerStopping
from trainer.runtime.priority import learning_threads
from trainer.runtime.run_data import RunData
from trainer.runtime.scratch import (
    COPIES,
    CheckpointCopies,
    fetch_newer_copy,
    own_scratch_folder,
    scratch_folder,
)
from trainer.runtime.stages import STAGE_WORK
from trainer.runtime.versions import versions
from tril.errors import TrilError
from tril.files.artifact_store import DISK_FULL, ArtifactStore, ArtifactStoreUnavailable
from tril.jobs import RunEta
from tril.recipes import recipe_from_dict
from tril.settings import Settings
from tril.stages import Stage, stages_of
from tril.store import behaviours
from tril.store.database import Database, is_busy, is_unreachable
from tril.store.models import RunStatus
from tril.store.training import leases, runs
from tril.store.training.artifacts import ArtifactDamaged
from tril.store.training.leases import Lease, LeaseLost

log = logging.getLogger(__name__)

MADE_BY = {
    "reward_model": Stage.REWARD,
    "clone": Stage.CLONE,
    "imitator": Stage.IMITATOR,
    "attention_map": Stage.ATTENTION,
    "attention_frame": Stage.ATTENTION,
    "attention_red_blue": Stage.ATTENTION,
}
"""The stage that makes each kind of file that later stages read."""

FINISHED = "finished"
LEASE_LOST = "leased to another worker"
GIVEN_BACK = "given back to the queue"
LEFT = "left in the queue"
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
        self._busy = threading.Lock()
        self._at_work: dict[str, RunData] = {}
        # Of a store that only this machine has, no other machine could take a copy.
        self._copies_checkpoints = bool(settings.artifacts_url)
        self._copies: dict[str, CheckpointCopies] = {}

    @property
    def run_ids(self) -> list[str]:
        """The runs at work, at most one."""
        return list(self._at_work)

    def beat(self, session: Session) -> None:
        """Write the heartbeat of the runs at work."""
        for data in list(self._at_work.values()):
            data.context.beat(session)

    def sweep(self) -> None:
        """Remove the checkpoints of runs that are done or deleted, and their copies."""
        folders = self._settings.data / "runs"
        run_ids = [folder.name for folder in folders.iterdir()] if folders.is_dir() else []
        if self._copies_checkpoints:
            try:
                run_ids += self._artifacts.names(COPIES)
            except ArtifactStoreUnavailable as problem:
                log.warning("Old copies of checkpoints could not be looked for: %s", problem)
        with self._database.reading() as session:
            not_resumable = runs.not_resumable(session, set(run_ids))
        for run_id in not_resumable:
            self._remove_checkpoints(run_id)

    def _remove_checkpoints(self, run_id: str) -> None:
        shutil.rmtree(scratch_folder(self._settings, run_id), ignore_errors=True)
        if self._copies_checkpoints:
            try:
                self._artifacts.remove_folder(f"{COPIES}/{run_id}")
            except ArtifactStoreUnavailable as problem:
                # The next sweep finds them.
                log.warning("Run %s: its copies could not be removed: %s", run_id, problem)

    def train(self, run_id: str, run_stage: RunStage) -> str:
        """Lease a run and take it through its stages.

        Args:
            run_id: The run.
            run_stage: Runs one stage, by way of ``self.run_stage``.

        Returns:
            How it ended, for the log.
        """
        # Two queues may hand out a run at the same moment; the second run gets a new job.
        if self._stopping.is_set() or not self._busy.acquire(blocking=False):
            log.info("Run %s: %s.", run_id, LEFT)
            return LEFT
        try:
            return self._train(run_id, run_stage) if self._has_store(run_id) else LEFT
        finally:
            self._busy.release()

    def _has_store(self, run_id: str) -> bool:
        """Whether a shared artifact store can be used; if not, the run waits and says why."""
        if not self._copies_checkpoints:
            return True
        try:
            self._artifacts.check(self._worker)
        except ArtifactStoreUnavailable as problem:
            log.warning("Run %s: %s", run_id, problem)
            with self._database.writing() as session:
                leases.note_waiting_reason(session, run_id, store_unavailable_message(problem))
            return False
        return True

    def _train(self, run_id: str, run_stage: RunStage) -> str:
        with self._database.writing() as session:
            lease = leases.acquire(session, run_id, self._worker)
        if lease is None:
            log.info("Run %s: nothing to do.", run_id)
            return "nothing to do"
        try:
            self._fetch_checkpoints(run_id)
            context = self._context(lease)
            with self._database.writing() as session:
                leases.keep_versions(session, lease, versions(context.game))
        except ArtifactStoreUnavailable as problem:
            return self._wait_for_store(lease, problem)
        except Exception as problem:
            # E.g. a recipe of another version, or the behaviour was deleted.
            log.exception("Run %s can't be started.", run_id)
            return self._end(lease, RunStatus.FAILED, failure_message("start", problem, run_id))
        self._at_work[run_id] = RunData(context)
        try:
            with self._checkpoint_copies(context):
                result = self._run_stages(context, run_stage)
            if result == RunStatus.DONE:
                self._remove_checkpoints(run_id)
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
            return self._write_result(context.lease, leases.release, GIVEN_BACK)
        return self._end(context.lease, RunStatus.DONE)

    @contextmanager
    def _checkpoint_copies(self, context: RunContext) -> Iterator[None]:
        """Copy a run's checkpoints within the block, if another machine may have to go on."""
        if not self._copies_checkpoints:
            yield
            return
        copies = CheckpointCopies(
            self._artifacts, context.run_id, context.folder, lambda: context.run.finished_stages
        )
        with copies:
            self._copies[context.run_id] = copies
            try:
                yield
            finally:
                del self._copies[context.run_id]

    def _copy_checkpoints(self, run_id: str) -> None:
        """Copy a run's checkpoints before others may go on with it."""
        if run_id in self._copies:
            self._copies[run_id].copy()

    def run_stage(self, run_id: str, name: str) -> str:
        """Run one stage of the run at work; however it ends is written to the run."""
        data, stage = self._at_work[run_id], Stage(name)
        lease = data.context.lease
        try:
            if stage not in data.context.run.finished_stages:
                self._work(data, stage)
            run = data.context.run
            check = run.outcome.check if stage is Stage.CHECK else None
            needed = data.context.recipe.method != "gail" and not run.go_on_anyway
            if check is not None and not check.passed and needed:
                return self._end(lease, RunStatus.STOPPED, check.advice)
            return FINISHED
        except LeaseLost:
            # The queue's record of this stage will be refused, too, and end the job here.
            log.info("Run %s: %s.", run_id, LEASE_LOST)
            return LEASE_LOST
        except WorkerStopping:
            self._copy_checkpoints(run_id)
            return self._write_result(lease, leases.release, GIVEN_BACK)
        except RunCancelled:
            self._copy_checkpoints(run_id)
            return self._end(lease, RunStatus.CANCELLED)
        except Exception as problem:
            if isinstance(problem, ArtifactStoreUnavailable) and self._copies_checkpoints:
                return self._wait_for_store(lease, problem)
            if isinstance(problem, DBAPIError) and (is_unreachable(problem) or is_busy(problem)):
                # Nothing is wrong with the run. If it can't be given back, its lease is revoked.
                log.warning("Run %s: the database can't be written: %s", run_id, problem.orig)
                return self._write_result(lease, leases.release, GIVEN_BACK)
            if (repaired := self._repair(data, stage, problem)) is not None:
                return repaired
            # The one catch-all: the person is told and the worker lives on.
            self._write_log(run_id, stage)
            log.exception("Run %s: stage %s failed.", run_id, stage)
            self._copy_checkpoints(run_id)
            return self._end(lease, RunStatus.FAILED, failure_message(stage, problem, run_id))

    def _work(self, data: RunData, stage: Stage) -> None:
        context = data.context
        log.info("Run %s: stage %s begins.", context.run_id, stage)
        # torch counts threads for each thread separately.
        torch.set_num_threads(self._threads)
        context.check_cancelled()
        progress = StageProgress(context, stage)
        progress.report()
        outcome = STAGE_WORK[stage](data, progress)
        seconds = progress.seconds()
        context.finish_stage(stage, seconds, outcome)
        log.info("Run %s: stage %s is finished after %.1f s.", context.run_id, stage, seconds)

    def _repair(self, data: RunData, stage: Stage, problem: Exception) -> str | None:
        """Give a run back to the queue if what it goes on from was damaged and can be made again.

        A damaged checkpoint is removed, so that the stage begins anew; the stage that has made a
        damaged file is done again.

        Returns:
            How the run left this worker; None if nothing can be done about the problem.
        """
        context = data.context
        if isinstance(problem, CheckpointDamaged):
            problem.path.unlink(missing_ok=True)
            again = stage
        elif isinstance(problem, ArtifactDamaged) and problem.run_id == context.run_id:
            if problem.kind not in MADE_BY:
                return None
            again = MADE_BY[problem.kind]
        else:
            return None
        self._write_log(context.run_id, stage)
        message = f"{problem} The stage \u201c{again.label}\u201d is done again."
        log.warning("Run %s: %s", context.run_id, message)

        def write(session: Session, lease: Lease) -> None:
            stages = stages_of(context.run.example)
            leases.reopen_stages(session, lease, stages[stages.index(again) :])
            leases.release(session, lease, message)

        return self._write_result(context.lease, write, GIVEN_BACK)

    def _fetch_checkpoints(self, run_id: str) -> None:
        if self._copies_checkpoints:
            fetch_newer_copy(self._artifacts, run_id, scratch_folder(self._settings, run_id))

    def _context(self, lease: Lease) -> RunContext:
        with self._database.reading() as session:
            run = runs.get(session, lease.run_id)
            root = scratch_folder(self._settings, run.id)
            return RunContext(
                lease=lease,
                run=run,
                behaviour=behaviours.as_behaviour(behaviours.get(session, run.behaviour_id)),
                recipe=recipe_from_dict(run.recipe),
                database=self._database,
                artifacts=self._artifacts,
                folder=own_scratch_folder(root, lease.epoch),
                settings=self._settings,
                eta=RunEta.of(session, run),
                threads=self._threads,
                stopping=self._stopping,
            )

    def _wait_for_store(self, lease: Lease, problem: ArtifactStoreUnavailable) -> str:
        """Give a run back to the queue, from which it is taken up when the store can be used."""
        log.warning("Run %s: %s", lease.run_id, problem)
        write = partial(leases.release, message=store_unavailable_message(problem))
        return self._write_result(lease, write, GIVEN_BACK)

    def _end(self, lease: Lease, status: RunStatus, message: str = "") -> str:
        return self._write_result(
            lease, partial(leases.end, status=status, message=message), status
        )

    def _write_result(
        self, lease: Lease, write: Callable[[Session, Lease], None], result: str
    ) -> str:
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
            with path.open("a", encoding="utf-8") as file:
                file.write(f"{datetime.now(UTC).isoformat()} stage {stage}\n")
                traceback.print_exc(file=file)
        except OSError as problem:
            log.warning("The log of run %s could not be written: %s", run_id, problem)


def store_unavailable_message(problem: ArtifactStoreUnavailable) -> str:
    """Return the message about a run that waits for the artifact store."""
    return f"{problem} The training goes on by itself as soon as it can be used again."


def failure_message(stage: str, problem: BaseException, run_id: str) -> str:
    """Return the message about a failed stage: the reason and the next step."""
    if isinstance(problem, TrilError):
        return str(problem)
    if isinstance(problem, OSError) and problem.errno in {errno.ENOSPC, errno.EDQUOT}:
        return DISK_FULL
    is_full = isinstance(problem, (MemoryError, torch.OutOfMemoryError))
    if is_full or "not enough memory" in str(problem):
        return (
            "There was not enough memory. Close other programs, then resume; what was learned so "
            "far is kept. If that is not enough, start a new run that plays fewer games at a time: "
            "`tril train BEHAVIOUR --set policy.n_envs=4`."
        )
    return (
        f"Something unexpected went wrong in the stage \u201c{stage}\u201d: "
        f"{type(problem).__name__}: {problem}. The details are in logs/runs/{run_id}.log in the "
        "data folder. Resume to try again from the last checkpoint."
    )
