"""A campaign: real processes, clients at work, one fault after the other, then the checks."""

from __future__ import annotations

import os
import shutil
import tempfile
import time
from collections import Counter, defaultdict
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import httpx2
import numpy as np
import psutil
from sqlalchemy import select

from testsupport.databases import CHOICE, corrupt_databases
from testsupport.faults.clients import (
    BEHAVIOUR,
    Client,
    Librarian,
    Player,
    Trainer,
    deletion_of,
    digest,
    name_of,
    notes_of,
)
from testsupport.faults.clocks import Clock, build
from testsupport.faults.history import Fault, History, Kind
from testsupport.faults.injection import KINDS, Target, draw, mount, possible, unmount
from testsupport.faults.ledger import Entry, keep_ledger, read_ledger
from testsupport.faults.members import PostgresMember, StoreMember, tril_member
from testsupport.faults.network import MAIN, Network
from testsupport.faults.rules import Found, Lost, Stored, lost_training, violations
from testsupport.live import cookie
from testsupport.ports import free_port
from testsupport.postgres import SERVER
from testsupport.waiting import wait_until
from testsupport.worker_kills import flaws
from testsupport.workplace import Workplace, make_workplace
from tril.errors import NotFound, Unavailable
from tril.files.artifact_store import ArtifactStore
from tril.game.console import Console
from tril.inference import InferenceClient, endpoint_of
from tril.recording import RecordingRefused, verify
from tril.settings import Settings
from tril.store import rankings, recordings
from tril.store.database import database_now
from tril.store.models import (
    ArtifactRow,
    ProcessRow,
    RankingRow,
    RecordingRow,
    RecordingState,
    RunRow,
    RunStatus,
    Verification,
)

RECOVERS_WITHIN_S = 240.0
FINISHES_WITHIN_S = 1200.0
"""Until every run is done once the last fault is healed."""

DISK_BYTES = 2 * 2**30
MOST_NEW_DESCRIPTORS = 64
LEAVES_WITHIN_S = 20.0
SWEPT_WITHIN_S = 90.0
"""Workers look once a minute for scratch folders that nobody needs."""

DATABASE_HOST, STORE_HOST = "database", "store"


@dataclass(frozen=True)
class Plan:
    """What a campaign does.

    Attributes:
        n_faults: How many faults.
        seed: Of everything that is drawn.
        database: ``sqlite`` or ``postgresql``.
        store: ``folder`` or ``s3``.
        n_servers: How many servers.
        n_workers: How many workers; with two, one takes over from the other.
        kinds: The kinds of fault to draw from; None for all that are possible here.
        in_turn: Whether the kinds are taken in turn instead of drawn.
        quiet_s: Shortest and longest time between recovery and the next fault.
        most_s: No fault begins after so many seconds.
        steps: PPO steps of the runs to draw from: a run of seconds, and one that is longer than
            most faults.
        runs_at_once: How many runs there are to be that are not over.
    """

    n_faults: int
    seed: int = 0
    database: str = "sqlite"
    store: str = "folder"
    n_servers: int = 1
    n_workers: int = 2
    kinds: tuple[str, ...] | None = None
    in_turn: bool = False
    quiet_s: tuple[float, float] = (1.0, 8.0)
    most_s: float = float("inf")
    steps: tuple[int, ...] = (256, 4096)
    runs_at_once: int = 2


@dataclass
class Result:
    """What came of a campaign.

    Attributes:
        violations: Every rule that was broken; empty is what is wanted.
        history: What clients were told, and the faults.
        ledger: Every change of the runs.
        runs: Status by run.
        impossible: Kinds of fault that can't be done here.
        seconds: How long it took.
    """

    violations: list[str] = field(default_factory=list)
    history: History = field(default_factory=History)
    ledger: Sequence[Entry] = ()
    runs: dict[str, str] = field(default_factory=dict)
    impossible: list[str] = field(default_factory=list)
    seconds: float = 0.0

    @property
    def recoveries_s(self) -> dict[str, list[float]]:
        """Seconds from the end of each fault until everything answered again, by kind."""
        found: dict[str, list[float]] = defaultdict(list)
        for fault in self.history.faults:
            if fault.recovered_s is not None:
                found[fault.kind].append(fault.recovered_s - fault.healed_s)
        return found

    @property
    def answers(self) -> Counter[str]:
        """How many requests were acknowledged, refused, or not answered."""
        return Counter(
            "acknowledged" if request.is_acknowledged else str(request.status or "unanswered")
            for request in self.history.requests
        )

    @property
    def lost(self) -> list[Lost]:
        """Training that had to be done again."""
        return lost_training(self.ledger)

    @property
    def lost_frames(self) -> list[int]:
        """Frames lost by each game whose connection broke."""
        return [
            max(0, request.value - request.answer)
            for request in self.history.requests
            if request.kind is Kind.REJOIN and request.is_acknowledged
        ]


def run_campaign(plan: Plan, folder: Path, say: Callable[[str], None] = print) -> Result:
    """Run a campaign in an empty folder, which holds logs and histories afterwards.

    Raises:
        AssertionError: Tril does not start, or does not recover from a fault.
    """
    rng = np.random.default_rng(plan.seed)
    result = Result()
    began_s = time.monotonic()
    with _system(plan, folder) as (workplace, target, servers):
        try:
            _Campaign(plan, workplace, target, servers, result, rng, say).run(began_s)
        finally:
            result.history.write(folder / "history.jsonl")
    result.violations += _left_running(folder)
    result.seconds = time.monotonic() - began_s
    return result


@contextmanager
def _system(plan: Plan, folder: Path) -> Iterator[tuple[Workplace, Target, list[Settings]]]:
    """Provide a workplace, the processes of a Tril on it, not started yet, and its servers."""
    with ExitStack() as stack:
        disks, logs = folder / "disks", folder / "logs"
        logs.mkdir()
        target = Target([])
        fills_disk = plan.kinds is None or "fill disk" in plan.kinds
        if fills_disk and os.geteuid() == 0:
            mount(disks, DISK_BYTES)
            target.disk, target.disk_bytes = disks, DISK_BYTES
            stack.callback(unmount, disks)
        if plan.database == "postgresql":
            _start_network(plan, target, stack)
            _start_database(folder, target, stack)
        url = _start_store(folder, target, stack) if plan.store == "s3" else ""
        workplace = make_workplace(disks / "data")
        stack.callback(workplace.database.close)
        keep_ledger(workplace.database)
        workplace = replace(
            workplace, settings=workplace.settings.model_copy(update={"artifacts_url": url})
        )
        servers = _add_members(plan, folder, workplace.settings, target)
        for member in target.members:
            stack.callback(member.stop)
        yield workplace, target, servers


def _start_network(plan: Plan, target: Target, stack: ExitStack) -> None:
    if not Network.is_possible():
        return
    stores = [STORE_HOST] if plan.store == "s3" else []
    hosts = [_host_of(name) for name in _names(plan)]
    target.network = Network((MAIN, DATABASE_HOST, *stores, *hosts))
    stack.callback(target.network.close)
    target.network.open()


def _names(plan: Plan) -> list[str]:
    """Return the servers and the workers, each of which is a machine where there are several."""
    return [
        f"{kind} {number}"
        for kind, how_many in (("server", plan.n_servers), ("worker", plan.n_workers))
        for number in range(1, how_many + 1)
    ]


def _host_of(name: str) -> str:
    return name.replace(" ", "-")


def _start_database(folder: Path, target: Target, stack: ExitStack) -> None:
    folder.chmod(0o755)  # the server runs as another user
    place = folder / "postgresql"
    place.mkdir()
    command = target.network.command(DATABASE_HOST) if target.network else []
    address = target.network.address(DATABASE_HOST) if target.network else None
    target.database = PostgresMember(place, command, address)
    target.database.start()
    stack.callback(target.database.stop)
    _set_variables({SERVER: str(place), CHOICE: "postgresql"}, stack)


def _start_store(folder: Path, target: Target, stack: ExitStack) -> str:
    """Start the S3 server and let processes know it; returns the URL of the store."""
    network = target.network
    address = network.address(STORE_HOST) if network else "127.0.0.1"
    command = network.command(STORE_HOST) if network else []
    target.store = StoreMember(folder, address, free_port(), command)
    target.store.start()
    stack.callback(target.store.stop)
    _set_variables(target.store.server.environment(), stack)
    return target.store.server.new_bucket()


def _set_variables(variables: dict[str, str], stack: ExitStack) -> None:
    os.environ.update(variables)
    for name in variables:
        stack.callback(os.environ.pop, name)


def _url_in_network(settings: Settings, target: Target) -> str:
    """Return the database's URL as processes on other hosts know it."""
    if target.network is None or target.database is None:
        return settings.database_url
    at = target.network.address(DATABASE_HOST)
    return settings.database_url.partition("@")[0] + f"@{at}/" + _name_in(settings.database_url)


def _name_in(url: str) -> str:
    return url.partition("@/")[2].partition("?")[0]


def _add_members(plan: Plan, folder: Path, settings: Settings, target: Target) -> list[Settings]:
    """Add the processes; returns the settings of the servers.

    Where there is a network, every server and every worker is on a machine of its own. Servers
    have one data folder, as they have on one machine.
    """
    network, servers = target.network, list[Settings]()
    library = build(folder) if target.database is not None else None
    shared = settings.model_copy(
        update={"learning_threads": 1, "database_url": _url_in_network(settings, target)}
    )
    target.members.append(tril_member("inference", shared, folder / "logs"))
    for name in _names(plan):
        kind, of_host = name.partition(" ")[0], dict[str, Any]()
        if kind == "server":
            of_host["port"] = free_port()
            if network is not None:
                of_host |= {"host": network.address(_host_of(name)), "plain_http": True}
                of_host["allowed_hosts"] = of_host["host"]
        elif network is not None:
            of_host["data"] = folder / "disks" / _host_of(name)
            of_host["artifacts_url"] = settings.artifact_root
        mine = shared.model_copy(update=of_host)
        if kind == "server":
            servers.append(mine)
        host = network.command(_host_of(name)) if network else []
        clock = Clock(library, folder / f"{_host_of(name)}.clock") if library else None
        target.members.append(tril_member(name, mine, folder / "logs", host, clock))
    return servers


class _Campaign:
    """A campaign at work."""

    def __init__(
        self,
        plan: Plan,
        workplace: Workplace,
        target: Target,
        servers: Sequence[Settings],
        result: Result,
        rng: np.random.Generator,
        say: Callable[[str], None],
    ) -> None:
        self._plan = plan
        self._workplace = workplace
        self._target = target
        self._result = result
        self._rng = rng
        self._say = say
        self._settings = workplace.settings
        self._servers = servers
        self._workers = target.of_kind("worker")
        self._cookie = "; ".join(map(cookie, servers))  # each port has a name of its own for it
        self._descriptors: dict[int, int] = {}

    def run(self, began_s: float) -> None:
        """Start everything, hurt it, let it finish, and check."""
        result, plan = self._result, self._plan
        only = None if plan.kinds is None else set(plan.kinds)
        kinds = possible(self._target, only)
        result.impossible = [name for name in plan.kinds or KINDS if name not in kinds]
        for member in self._target.members:
            member.start()
        self._wait_for_recovery()
        with self._workplace.database.reading() as session:
            first_revision = rankings.current(session, BEHAVIOUR).revision
        clients = self._clients()
        for client in clients:
            client.start()
        for number in range(plan.n_faults):
            if time.monotonic() - began_s > plan.most_s:
                break
            time.sleep(float(self._rng.uniform(*plan.quiet_s)))
            drawn = draw(self._target, self._rng, only)
            kind = kinds[number % len(kinds)] if plan.in_turn else drawn
            self._hurt(kind, number)
            for client in clients:
                if client.crashed is not None:
                    raise client.crashed
        trainer = next(client for client in clients if isinstance(client, Trainer))
        self._finish(clients)
        references = self._references(trainer.run_ids)
        result.ledger = read_ledger(self._workplace.database)
        found = self._found(first_revision, references)
        result.runs = dict(found.runs)
        requests, faults = result.history.requests, result.history.faults
        result.violations += violations(requests, faults, found)

    def _clients(self) -> list[Client]:
        common = (self._result.history, self._servers, self._cookie)
        seeds = self._rng.spawn(3)
        return [
            Librarian(*common, seeds[0]),
            Player(*common, seeds[1]),
            Trainer(self._workplace, self._plan.steps, self._plan.runs_at_once, *common, seeds[2]),
        ]

    def _hurt(self, kind: str, number: int) -> None:
        began_s = time.monotonic()
        KINDS[kind].inject(self._target, self._rng)
        healed_s = time.monotonic()
        recovered_s: float | None = None
        try:
            for member in self._target.members:
                if not member.is_alive:  # a fault of its disk or database may have ended it
                    member.start()
            self._wait_for_recovery()
            recovered_s = time.monotonic()
        finally:
            self._result.history.add(Fault(kind, began_s, healed_s, recovered_s))
        took_s = recovered_s - healed_s
        self._say(
            f"{number + 1:4} {kind:22} {healed_s - began_s:5.1f} s, back after {took_s:.1f} s"
        )

    def _wait_for_recovery(self) -> None:
        """Wait until every process has answered a question of now; starts none."""
        with self._workplace.database.reading() as session:
            since = database_now(session)

        def beats(pid: int) -> bool:
            with self._workplace.database.reading() as session:
                query = select(ProcessRow.heartbeat_at).where(ProcessRow.pid == pid)
                heard = session.scalars(query).all()
            return any(at > since for at in heard)

        def serves(server: Settings) -> bool:
            try:
                with self._http(server) as http:
                    return http.get("/api/runs").is_success
            except httpx2.HTTPError:
                return False

        def judges() -> bool:
            try:
                InferenceClient(endpoint_of(self._settings)).ping()
            except Unavailable:
                return False
            return True

        def everything() -> bool:
            for member in self._target.members:
                if not member.is_alive:
                    member.start()
            return (
                all(map(serves, self._servers))
                and judges()
                and all(beats(member.pid) for member in self._target.members)
            )

        wait_until(everything, RECOVERS_WITHIN_S, self._logs)
        for member in self._target.members:
            process = psutil.Process(member.pid)
            self._descriptors.setdefault(member.pid, process.num_fds())

    def _http(self, server: Settings) -> httpx2.Client:
        return httpx2.Client(
            base_url=f"http://{server.host}:{server.port}",
            headers={"Cookie": self._cookie},
            timeout=10.0,
        )

    def _logs(self) -> str:
        tails = (
            f"{member.name}:\n{member.log.read_text(errors='replace')[-1500:]}"
            for member in self._target.members
        )
        return "\n".join(tails)

    def _finish(self, clients: Sequence[Client]) -> None:
        """Let every client finish what it has begun, runs last."""
        began_s = time.monotonic()
        for client in clients:
            client.leave(FINISHES_WITHIN_S)
            if client.crashed is not None:
                raise client.crashed
        self._say(f"     everything was finished after {time.monotonic() - began_s:.0f} s")

    def _references(self, run_ids: Sequence[str]) -> dict[int, str]:
        """Train one run of each length that nothing happens to."""
        with self._workplace.database.reading() as session:
            lengths = {
                row.steps for row in session.scalars(select(RunRow)) if row.id in set(run_ids)
            }
        made = {steps: self._workplace.make_run(steps=steps) for steps in sorted(lengths)}

        def are_done() -> bool:
            return all(self._workplace.run(key).status == RunStatus.DONE for key in made.values())

        wait_until(are_done, FINISHES_WITHIN_S, self._logs)
        return made

    def _found(self, first_revision: int, references: dict[int, str]) -> Found:
        database = self._workplace.database
        with database.reading() as session:
            of_recordings = list(session.scalars(select(RecordingRow)))
            of_runs = list(session.scalars(select(RunRow)))
            of_ranking = session.scalars(
                select(RankingRow).where(RankingRow.behaviour_id == BEHAVIOUR)
            )
            revisions = {row.revision: row.tiers for row in of_ranking}
        values: dict[str, object] = {}
        for recording in of_recordings:
            values[notes_of(recording.id)] = recording.notes
            values[deletion_of("recording", recording.id)] = recording.deleted_at is not None
        for run in of_runs:
            values[name_of(run.id)] = run.name
            values[deletion_of("run", run.id)] = run.deleted_at is not None
        unlike = [
            f"Run {run.id}: {flaw}"
            for run in of_runs
            if run.id not in references.values() and run.steps in references
            for flaw in flaws(self._workplace, run.id, references[run.steps])
        ]
        return Found(
            values=values,
            recordings=dict(_stored(of_recordings)),
            revisions=revisions,
            first_revision=first_revision,
            runs={run.id: run.status for run in of_runs},
            ledger=self._result.ledger,
            left_behind=[*self._open_descriptors(), *self._left_on_disk(of_runs)],
            damaged=[*corrupt_databases(self._settings.data), *self._missing_files()],
            unlike=unlike,
        )

    def _missing_files(self) -> list[str]:
        """Return the files that the database names and the store does not have as they were."""
        store = ArtifactStore(self._settings.artifact_root)
        with self._workplace.database.reading() as session:
            named = {row.path: row.size_bytes for row in session.scalars(select(ArtifactRow))}
        found = []
        for path, size_bytes in named.items():
            try:
                stored = len(store.get(path))
            except NotFound:
                stored = None
            if stored != size_bytes:
                found.append(f"The file {path} of {size_bytes} bytes is {stored} in the store.")
        return found

    def _open_descriptors(self) -> Iterator[str]:
        for member in self._target.members:
            before = self._descriptors[member.pid]
            now = psutil.Process(member.pid).num_fds()
            if now > before + MOST_NEW_DESCRIPTORS:
                yield f"The {member.name} holds {now} descriptors, {before} after its start."

    def _left_on_disk(self, of_runs: Sequence[RunRow]) -> list[str]:
        """Return the scratch folders of finished runs that are left, once they may not be."""
        done = {run.id for run in of_runs if run.status == RunStatus.DONE}
        folders = {Path(member.environment["TRIL_DATA"]) / "runs" for member in self._workers}

        def left() -> list[Path]:
            return [place for folder in folders for place in folder.glob("*") if place.name in done]

        give_up_at = time.monotonic() + SWEPT_WITHIN_S
        while left() and time.monotonic() < give_up_at:
            time.sleep(0.2)
        return [f"The scratch folder {place} is left, though its run is done." for place in left()]


def _stored(rows: Sequence[RecordingRow]) -> Iterator[tuple[int, Stored]]:
    """Yield every recording of people, replayed."""
    console = Console()
    for row in rows:
        if row.state == RecordingState.PLAYING or row.behaviour_id != BEHAVIOUR:
            continue
        recording = recordings.as_recording(row)
        refusal: str | None = None
        if row.verification != Verification.VERIFIED:
            refusal = row.verification_note or "Nobody has replayed it yet."
        else:
            try:
                verify(recording, console=console)
            except RecordingRefused as problem:
                refusal = str(problem)
        yield row.id, Stored(digest(recording), row.n_frames, row.behaviour_id, refusal)


def _left_running(folder: Path) -> list[str]:
    """Return the processes that are still there once everything was stopped."""

    def left() -> list[psutil.Process]:
        found = []
        for process in psutil.process_iter():
            try:
                if process.environ().get("TRIL_DATA", "").startswith(f"{folder}/"):
                    found.append(process)
            except psutil.Error:
                continue
        return found

    give_up_at = time.monotonic() + LEAVES_WITHIN_S
    while left() and time.monotonic() < give_up_at:
        time.sleep(0.2)
    return [f"Process {process.pid} is left: {process.cmdline()}" for process in left()]


@contextmanager
def campaign_folder() -> Iterator[Path]:
    """Provide an empty folder, which is removed unless the block fails."""
    folder = Path(tempfile.mkdtemp(prefix="tril-faults-"))
    yield folder
    shutil.rmtree(folder, ignore_errors=True)
