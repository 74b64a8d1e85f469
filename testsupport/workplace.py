"""A data folder as Tril makes it, with a small ranked behaviour, for tests of runs and workers."""

from __future__ import annotations

import atexit
import shutil
import tempfile
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

from testsupport.databases import copy_database, on_postgresql, settings_on
from tril.games.atari.starts import AtariStart
from tril.games.space_invaders import SPACE_INVADERS
from tril.games.space_invaders.memory import Action
from tril.jobs import prepare_queue
from tril.play.episode import Episode
from tril.recipes import FAST, Recipe, with_values
from tril.recording import Recorder, Recording, Replay
from tril.settings import Settings
from tril.store import behaviours, rankings, recordings
from tril.store.database import Database, create_database
from tril.store.models import RunDevice, RunRow, Source
from tril.store.schema import upgrade
from tril.store.training import leases, runs
from tril.store.training.leases import Lease
from tril.teaching.new_run import create_run

FRAMES = 240
"""Length of the test recordings: 60 steps."""

TINY_VALUES: dict[str, object] = {
    "name": "tiny",
    "reward.updates": 4,
    "reward.folds": 0,
    "policy.n_envs": 2,
    "policy.n_steps": 32,
    "policy.n_minibatches": 1,
    "policy.n_epochs": 1,
    "policy.critic_warm_up_steps": 0,
    "policy.snapshot_steps": (),
    "policy.snapshot_episodes": 1,
    "cloning.epochs": 2,
    "evaluation.start_numbers": (0,),
    "evaluation.further_start_numbers": (),
}

TINY = with_values(FAST, TINY_VALUES)
"""A whole run in seconds."""

Play = Callable[[int], Action]


@dataclass(frozen=True)
class Workplace:
    """A migrated data folder.

    Attributes:
        settings: Settings that name it.
        database: Its database, opened.
        behaviour_id: Column 1, with four ranked recordings, the best of them perfect.
        ranked: The recordings, best first.
    """

    settings: Settings
    database: Database
    behaviour_id: int
    ranked: tuple[int, ...]

    def make_run(
        self,
        recipe: Recipe = TINY,
        steps: int = 256,
        training_seed: int = 0,
        go_on_anyway: bool = True,
        parent_run_id: str | None = None,
        device: RunDevice = RunDevice.ANY,
    ) -> str:
        """Make a queued run, which goes on whatever the check of its ranking says."""
        with self.database.writing() as session:
            return create_run(
                session,
                self.behaviour_id,
                recipe,
                steps,
                training_seed,
                go_on_anyway,
                parent_run_id=parent_run_id,
                device=device,
            ).id

    def lease(self, run_id: str, worker: str = "worker-0") -> Lease:
        """Lease a run to a worker."""
        with self.database.writing() as session:
            lease = leases.acquire(session, run_id, worker)
        assert lease is not None
        return lease

    def run(self, run_id: str) -> RunRow:
        """Return a run's row as it stands."""
        with self.database.reading() as session:
            return runs.get(session, run_id)


def make_workplace(folder: Path) -> Workplace:
    """Make a data folder with four short recordings, ranked; made once and copied from then on."""
    settings, database = _copied(_template(on_postgresql()), folder)
    with database.reading() as session:
        behaviour_id = behaviours.by_slug(session, "column-1").id
        tiers = rankings.current(session, behaviour_id).tiers
    return Workplace(settings, database, behaviour_id, tuple(tier[0] for tier in tiers))


def copy_of(template: Workplace, folder: Path) -> Workplace:
    """Make a data folder like another one, whose database is closed."""
    settings, database = _copied(template.settings, folder)
    return replace(template, settings=settings, database=database)


def _copied(template: Settings, folder: Path) -> tuple[Settings, Database]:
    shutil.copytree(template.data, folder, dirs_exist_ok=True)
    copy_database(template, folder)
    settings = settings_on(folder, learning_threads=1, learning_niceness=0)
    return settings, create_database(settings.application_url)


@cache
def _template(_on_postgresql: bool) -> Settings:
    folder = Path(tempfile.mkdtemp(prefix="tril-tests-"))
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    settings = settings_on(folder)
    database = create_database(settings.application_url)
    upgrade(database)
    prepare_queue(settings)
    with database.writing() as session:
        behaviour_id = behaviours.by_slug(session, "column-1").id
        ranked = []
        for number, play in enumerate(_PLAYS):
            recording, played = _played(play)
            row = recordings.add(
                session, behaviour_id, recording, played, Source.SCRIPTED, perfect=number == 0
            )
            ranked.append(row.id)
        rankings.save(session, behaviour_id, 0, [[number] for number in ranked])
    database.close()
    return settings


def _played(play: Play) -> tuple[Recording, Replay]:
    recorder = Recorder(Episode(SPACE_INVADERS.make_console(), AtariStart(TRAINING_IDLE)))
    for frame in range(FRAMES):
        recorder.advance(play(frame))
    return recorder.recording(), recorder.replay()


TRAINING_IDLE = 4
"""Idle frames of the test recordings' start, which is no evaluation start."""

_PLAYS: tuple[Play, ...] = (
    lambda _frame: Action.FIRE,
    lambda _frame: Action.NOOP,
    lambda _frame: Action.RIGHT,
    lambda _frame: Action.RIGHTFIRE,
)
