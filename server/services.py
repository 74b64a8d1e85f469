"""What one server process works with, put together once when it starts."""

from __future__ import annotations

import asyncio
import os
import socket
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from dataclasses import dataclass, field

from server.change_stream import ChangeStream
from server.derived import Derived
from server.play.consoles import ConsolePool
from server.play.hub import N_SPARE_CONSOLES, PlayHub
from server.play.limits import GameLimits
from server.play.replays import ReplayProcess
from server.play.rules import PlayRules
from server.storage import StorageMeter
from server.web.security import Access
from tril.files.artifact_store import ArtifactStore
from tril.files.cache import Cache
from tril.heartbeat import Heartbeat
from tril.inference import InferenceClient
from tril.jobs import Jobs
from tril.recording import Recording, trajectory
from tril.settings import Settings
from tril.store.database import Database, create_database
from tril.store.schema import check_schema


@dataclass(frozen=True)
class Services:
    """What routes work with.

    Attributes:
        settings: The process's settings.
        database: The application's database.
        access: Checks tokens and cookies.
        artifacts: The files of trainings.
        jobs: The queue of trainings.
        inference: Answers for trained networks.
        consoles: Loaded consoles.
        derived: Frames and thumbnails.
        limits: How many games may be open.
        games: The games that are played in this process.
        changes: Tells pages what changes.
        storage: Tells how much room the files take.
        importing: Held while an upload is verified, so that one at a time is.
    """

    settings: Settings
    database: Database
    access: Access
    artifacts: ArtifactStore
    jobs: Jobs
    inference: InferenceClient
    consoles: ConsolePool
    derived: Derived
    limits: GameLimits
    games: PlayHub
    changes: ChangeStream
    storage: StorageMeter
    importing: asyncio.Semaphore = field(default_factory=lambda: asyncio.Semaphore(1))

    def rewards_of(self, run_id: str, recording: Recording) -> list[float]:
        """Ask the inference process for R of every observation of a recording."""
        with self.consoles.lent() as console:
            observations = trajectory(recording, console).observations
        return [float(value) for value in self.inference.reward(run_id, observations)]


def process_name() -> str:
    """Return a name that no other live server process has."""
    return f"server-{socket.gethostname()[:40]}-{os.getpid()}"


@asynccontextmanager
async def running_services(settings: Settings, rules: PlayRules) -> AsyncIterator[Services]:
    """Put the services together, run them for the block, and stop them in order.

    Raises:
        Unavailable: The database is of another version, or the access token can't be read.
    """
    settings.data.mkdir(parents=True, exist_ok=True)
    database = create_database(settings.application_url)
    check_schema(database)
    name = process_name()
    consoles = ConsolePool(rules.max_games + N_SPARE_CONSOLES)
    replays = ReplayProcess()
    limits = GameLimits.from_settings(settings, rules.max_games)
    jobs = Jobs(database, settings)
    services = Services(
        settings=settings,
        database=database,
        access=Access(settings),
        artifacts=ArtifactStore(settings.artifact_root),
        jobs=jobs,
        inference=InferenceClient(settings.inference_socket),
        consoles=consoles,
        derived=Derived(Cache(settings.cache_folder, settings.cache_limit_bytes), replays),
        limits=limits,
        games=PlayHub(database, consoles, replays, name, rules, limits),
        changes=ChangeStream(database),
        storage=StorageMeter(settings),
    )
    heartbeat = Heartbeat(database, name, "server")
    try:
        await asyncio.to_thread(heartbeat.start)
        services.changes.start()
        consoles.start()
        services.games.start()
        jobs.start_reconciling()
        yield services
    finally:
        await services.games.stop()
        await asyncio.to_thread(replays.stop)
        await asyncio.to_thread(consoles.stop)
        services.changes.stop()
        await asyncio.to_thread(heartbeat.stop)
        jobs.close()
        database.close()
