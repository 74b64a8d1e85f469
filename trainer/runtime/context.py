"""What a stage of a run works with: its data, where it reports to, and when it has to stop."""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

import torch
from sqlalchemy.orm import Session

from trainer.nn.devices import learning_device
from trainer.progress import RunCancelled
from tril.analysis.outcome import RunOutcome
from tril.files.artifact_store import ArtifactStore
from tril.games import game_of
from tril.games.base import Game
from tril.games.behaviours import Behaviour
from tril.jobs import RunEta, SteadyRemaining
from tril.recipes import Recipe
from tril.settings import Settings
from tril.stages import Stage
from tril.store.database import Database
from tril.store.models import RunRow
from tril.store.training import artifacts as artifact_rows
from tril.store.training import leases, metrics
from tril.store.training.leases import Lease

CHECK_EVERY_S = 1.0
"""How often the run's row is read for a request to stop."""

REPORT_EVERY_S = 1.0
SETTLED_SHARE = 0.02
"""Share of a stage that has to be done before its own rate tells the remaining time."""

SILENT_AFTER_S = 30.0
"""When a stage has got no further for so long, nothing tells the remaining time."""


class WorkerStopping(RunCancelled):
    """The worker is being stopped: the run goes back to the queue and on from its checkpoint."""


@dataclass
class RunContext:
    """One lease of one run, as its stages see it.

    Attributes:
        lease: The worker's lease; everything written to the run carries it.
        run: The run's row as of its last finished stage, detached from its session.
        behaviour: Behaviour to teach.
        recipe: Recipe of the run.
        database: The application's database.
        artifacts: Where files that outlive the run are kept.
        folder: Scratch folder of the run on this machine, for checkpoints.
        settings: Settings of the process.
        eta: Expected duration of the run's stages.
        threads: Threads that learning may use.
        stopping: Set when the worker is being stopped.
        remaining: What is told of the remaining time, over all stages.
    """

    lease: Lease
    run: RunRow
    behaviour: Behaviour
    recipe: Recipe
    database: Database
    artifacts: ArtifactStore
    folder: Path
    settings: Settings
    eta: RunEta
    threads: int
    stopping: threading.Event
    remaining: SteadyRemaining = field(default_factory=SteadyRemaining, init=False)
    _checked_at: float = field(default=-math.inf, init=False)
    _heard_at: float = field(default_factory=time.monotonic, init=False)

    @property
    def run_id(self) -> str:
        """Id of the run."""
        return self.lease.run_id

    @cached_property
    def game(self) -> Game:
        """The game that is played."""
        return game_of(self.behaviour)

    @cached_property
    def device(self) -> torch.device:
        """Where networks learn; raises Invalid if the settings want what there is not."""
        return learning_device(self.settings.learning_device)

    def check_cancelled(self) -> None:
        """Stop here if the run is to stop; reads the row at most once a second.

        Raises:
            RunCancelled: The run was cancelled.
            WorkerStopping: The worker is being stopped.
            LeaseLost: The run has passed to another worker.
        """
        if self.stopping.is_set():
            raise WorkerStopping
        if time.monotonic() - self._checked_at < CHECK_EVERY_S:
            return
        with self.database.reading() as session:
            cancelling = leases.is_cancelling(session, self.lease)
        self._checked_at = time.monotonic()
        if cancelling:
            raise RunCancelled

    def note_progress(self) -> None:
        """Note that the stage at work has just begun or got further."""
        self._heard_at = time.monotonic()

    def beat(self, session: Session) -> None:
        """Write the run's heartbeat, and that a stage that gets no further tells no end."""
        leases.beat(session, self.lease)
        if time.monotonic() - self._heard_at > SILENT_AFTER_S:
            leases.forget_remaining(session, self.lease)

    def stage_folder(self, stage: str) -> Path:
        """Return the folder of a stage's checkpoints on this machine; it is made if missing."""
        folder = self.folder / stage
        folder.mkdir(parents=True, exist_ok=True)
        return folder

    def save_artifact(
        self,
        kind: str,
        name: str,
        media_type: str,
        content: bytes,
        details: dict[str, Any] | None = None,
    ) -> None:
        """Put a file into the artifact store and name it on the run, replacing an earlier one."""
        with self.database.reading() as session:
            # A worker that has lost the run must not replace the file of the one that has it.
            leases.is_cancelling(session, self.lease)
        size = self.artifacts.put(artifact_rows.path_of(self.run_id, name), content)
        with self.database.writing() as session:
            leases.owned(session, self.lease)
            digest = artifact_rows.digest(content)
            artifact_rows.save(session, self.run_id, kind, name, media_type, size, details, digest)

    def finish_stage(self, stage: Stage, seconds: float, outcome: RunOutcome | None = None) -> None:
        """Write that a stage is finished, and what it has found, in one transaction."""
        with self.database.writing() as session:
            row = leases.finish_stage(session, self.lease, stage, seconds)
            if outcome is not None:
                row.outcome = row.outcome.updated_with(outcome)
        self.run = row


class StageProgress:
    """Where a learning function reports to: the run's row and its curves.

    A point is written at once, so that a checkpoint that is saved after it was reported is never
    ahead of the curve; learning reports at most some hundred points a stage. All else is written
    once a second.

    Args:
        context: The run.
        stage: The stage at work.
        clock: Seconds, monotonic.
    """

    def __init__(
        self, context: RunContext, stage: str, clock: Callable[[], float] = time.monotonic
    ) -> None:
        self._context = context
        self._stage = stage
        self._clock = clock
        self._began = self._reported_at = self._moved_at = clock()
        self._first_share: float | None = None
        # A stage that is begun again is at least as far as it was until it says where it goes on.
        self._share = context.run.stage_done if context.run.stage == stage else 0.0
        context.note_progress()

    def advance(self, done: int, total: int, values: Mapping[str, float] | None = None) -> None:
        """Report progress, see trainer.progress.Progress.

        The first call of a stage says where it goes on: points beyond it are of an attempt that
        ended without a checkpoint there, and are dropped.
        """
        share = done / total if total else 1.0
        if share != self._share:
            self._share, self._moved_at = share, self._clock()
            self._context.note_progress()
        if self._first_share is None:
            self._first_share = self._share
            with self._context.database.writing() as session:
                leases.owned(session, self._context.lease)
                metrics.drop_after(session, self._context.run_id, self._stage, done)
        if values or self._clock() - self._reported_at >= REPORT_EVERY_S:
            self.report(done, values)
        self._context.check_cancelled()

    def report(self, step: int = 0, values: Mapping[str, float] | None = None) -> None:
        """Write how far the stage is, and a point of its curves if there is one."""
        context = self._context
        with context.database.writing() as session:
            leases.report(session, context.lease, self._stage, self._share, self.remaining_s())
            if values:
                # JSON has no infinity; a curve has a gap there.
                point = {name: float(v) for name, v in values.items() if math.isfinite(v)}
                metrics.add(session, context.run_id, self._stage, step, point)
        self._reported_at = self._clock()

    def remaining_s(self) -> float | None:
        """Return the estimated seconds to the end of the whole run.

        None if the stage has got no further for a while.
        """
        if self._clock() - self._moved_at > SILENT_AFTER_S:
            return None
        gained = 0.0 if self._first_share is None else self._share - self._first_share
        took_s = self._moved_at - self._began
        if gained < SETTLED_SHARE:
            gained = took_s = 0.0
        context = self._context
        estimate_s = context.eta.remaining_s(
            context.run.finished_stages, self._stage, self._share, gained, took_s
        )
        return context.remaining.update(self._clock(), estimate_s)

    def seconds(self) -> float:
        """Return the duration of the whole stage, extrapolated if it began at a checkpoint."""
        took = self._clock() - self._began
        return took / max(SETTLED_SHARE, 1.0 - (self._first_share or 0.0))
