"""The services of a server process, built once at its start."""

from __future__ import annotations

import asyncio
import os
import socket
from collections.abc import AsyncIterator, Collection
from contextlib import asynccontextmanager
from dataclasses import dataclass, field
from functools import partial

from server.archives import ArchiveMaker
from server.change_stream import Change, ChangeStream
from server.concurrency import ConcurrencyLimit
from server.measurer import TOPICS, Measurer
from server.play.background import PeriodicTask
from server.play.consoles import ConsolePool
from server.play.hub import N_SPARE_CONSOLES, PlayHub
from server.play.limits import GameLimits
from server.play.replays import ReplayProcess
from server.play.rules import PlayRules
from server.play.watch.hub import WatchHub
from server.replay_cache import ReplayCache, keep_strip
from server.storage import StorageMeter
from server.understanding import OrderReader
from server.vocabularies import VocabularyMaker
from server.web.access import SEEN_EVERY_S, Access
from tril.files.artifact_store import ArtifactStore
from tril.files.cache import Cache
from tril.heartbeat import Heartbeat
from tril.inference import InferenceClient, endpoint_of
from tril.jobs import Jobs
from tril.settings import Settings
from tril.store.access import credentials
from tril.store.database import Database, create_database
from tril.store.schema import check_schema


@dataclass(frozen=True)
class Services:
    """The services that routes use.

    Attributes:
        settings: The process's settings.
        database: The application's database.
        access: Tells who makes a request.
        artifacts: The files of trainings.
        jobs: The queue of trainings.
        inference: Client of the inference process.
        consoles: Pool of loaded consoles.
        replays: The process that replays recordings and plays at random.
        replay_cache: Frames, film strips, memory and clips of recordings.
        vocabularies: Learns to see games.
        order_reader: Infers what orders of games are about.
        archives: Makes runs into zip files.
        limits: Limits of open games.
        games: The games that are played in this process.
        watching: The games that are watched in this process.
        changes: The change stream.
        storage: Measures disk usage.
        read_limit: Limits requests that read, one at a time of each person. Their threads
            share Python's lock with the games, so that more of them answer less. Together with
            those that write they have to be fewer than the pool's connections (15) and anyio's
            threads (40). Otherwise all threads wait for connections whose holders wait for a
            thread, in which FastAPI validates their answer.
        write_limit: Limits requests that write, so that reads do not wait for a busy database.
        replay_limit: Limits requests that make clips or archives, replay, query a network or read
            the artifact store. They hold a connection only briefly, but a thread for seconds.
        upload_limit: Limits uploads, one of each person, whose body is not read before they have a
            slot.
    """

    settings: Settings
    database: Database
    access: Access
    artifacts: ArtifactStore
    jobs: Jobs
    inference: InferenceClient
    consoles: ConsolePool
    replays: ReplayProcess
    replay_cache: ReplayCache
    vocabularies: VocabularyMaker
    order_reader: OrderReader
    archives: ArchiveMaker
    limits: GameLimits
    games: PlayHub
    watching: WatchHub
    changes: ChangeStream
    storage: StorageMeter
    read_limit: ConcurrencyLimit = field(
        default_factory=lambda: ConcurrencyLimit(at_once=4, per_client=1, waiting=64, wait_s=20)
    )
    write_limit: ConcurrencyLimit = field(
        default_factory=lambda: ConcurrencyLimit(at_once=2, per_client=1, waiting=64, wait_s=20)
    )
    replay_limit: ConcurrencyLimit = field(
        default_factory=lambda: ConcurrencyLimit(at_once=8, per_client=4, waiting=128, wait_s=120)
    )
    upload_limit: ConcurrencyLimit = field(
        default_factory=lambda: ConcurrencyLimit(at_once=2, per_client=1, waiting=8, wait_s=120)
    )


def process_name() -> str:
    """Return a name that is unique among live server processes."""
    return f"server-{socket.gethostname()[:40]}-{os.getpid()}"


@asynccontextmanager
async def running_services(settings: Settings, rules: PlayRules) -> AsyncIterator[Services]:
    """Build the services, run them for the block and stop them in order.

    Raises:
        Unavailable: The database is of another version, or the access token can't be read.
        Invalid: The settings don't say how to ask the inference process.
    """
    inference = endpoint_of(settings)
    settings.data.mkdir(mode=0o700, parents=True, exist_ok=True)
    database = create_database(settings.application_url)
    check_schema(database)
    name = process_name()
    consoles = ConsolePool(rules.max_games + N_SPARE_CONSOLES)
    limits = GameLimits.from_settings(settings, rules.max_games, name)
    jobs = Jobs(database, settings)
    cache = Cache(settings.cache_folder, settings.cache_limit_bytes)
    replays = ReplayProcess(partial(keep_strip, cache))
    access = Access(settings, database)

    measurer = Measurer(database, replays)

    def on_change(changes: Collection[Change]) -> None:
        if any(topic == credentials.CHANGES for topic, _ in changes):
            access.forget()
        if any(topic in TOPICS for topic, _ in changes):
            measurer.wake()

    replay_cache = ReplayCache(cache, replays)
    vocabularies = VocabularyMaker(settings.data)
    play = PlayHub(database, consoles, replays, name, rules, limits)
    services = Services(
        settings=settings,
        database=database,
        access=access,
        artifacts=ArtifactStore(settings.artifact_root),
        jobs=jobs,
        inference=InferenceClient(inference),
        consoles=consoles,
        replays=replays,
        replay_cache=replay_cache,
        vocabularies=vocabularies,
        order_reader=OrderReader(vocabularies, replay_cache),
        archives=ArchiveMaker(settings, cache),
        limits=limits,
        games=play,
        watching=WatchHub(database, consoles, play, inference, rules, limits),
        changes=ChangeStream(database, on_change),
        storage=StorageMeter(settings),
    )
    last_seen = PeriodicTask("last seen", access.save_last_use, SEEN_EVERY_S)
    heartbeat = Heartbeat(database, name, "server", limits.watched.details)
    try:
        await asyncio.to_thread(heartbeat.start)
        services.changes.start()
        last_seen.start()
        consoles.start()
        services.games.start()
        services.watching.start()
        measurer.start()
        jobs.start_reconciling()
        yield services
    finally:
        await services.watching.stop()
        await services.games.stop()
        await measurer.stop()
        await asyncio.to_thread(services.order_reader.stop)
        await asyncio.to_thread(vocabularies.stop)
        await asyncio.to_thread(replays.stop)
        await asyncio.to_thread(consoles.stop)
        services.changes.stop()
        await last_seen.stop()
        await access.stop()
        await asyncio.to_thread(heartbeat.stop)
        jobs.close()
        database.close()
