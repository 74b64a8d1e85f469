"""A campaign: real processes, clients at work, one fault after the other, then the checks."""

from __future__ import annotations

import shutil
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import httpx2
import numpy as np
from sqlalchemy import select

from testsupport.faults.clients import BEHAVIOUR, Client, Librarian, Player, Trainer
from testsupport.faults.history import Fault
from testsupport.faults.injection import KINDS, Target, draw, possible
from testsupport.faults.plan import Plan, Result
from testsupport.faults.remains import Remains, left_running
from testsupport.faults.rules import violations
from testsupport.faults.system import running_system
from testsupport.live import cookie
from testsupport.waiting import wait_until
from testsupport.workplace import Workplace
from tril.errors import Unavailable
from tril.inference import InferenceClient, endpoint_of
from tril.settings import Settings
from tril.store import rankings
from tril.store.database import database_now
from tril.store.models import ProcessRow, RunRow, RunStatus

RECOVERS_WITHIN_S = 240.0
FINISHES_WITHIN_S = 1200.0
"""Until every run is done once the last fault is healed."""


def run_campaign(plan: Plan, folder: Path, say: Callable[[str], None] = print) -> Result:
    """Run a campaign in an empty folder, which holds logs and histories afterwards.

    Raises:
        AssertionError: Tril does not start, or does not recover from a fault.
    """
    rng = np.random.default_rng(plan.seed)
    result = Result()
    began_s = time.monotonic()
    with running_system(plan, folder) as (workplace, target, servers):
        try:
            _Campaign(plan, workplace, target, servers, result, rng, say).run(began_s)
        finally:
            result.history.write(folder / "history.jsonl")
    result.violations += left_running(folder)
    result.seconds = time.monotonic() - began_s
    return result


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
        self._cookie = "; ".join(map(cookie, servers))  # each port has a name of its own for it
        self._remains = Remains(workplace, target)

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
        found = self._remains.found(first_revision, references)
        result.ledger = found.ledger
        result.runs = dict(found.runs)
        requests, faults = result.history.requests, result.history.faults
        result.violations += violations(requests, faults, found)

    def _clients(self) -> list[Client]:
        common = (self._result.history, self._servers, self._cookie)
        seeds = self._rng.spawn(3)
        return [
            Librarian(*common, seeds[0]),
            Player(*common, seeds[1]),
            Trainer(self._workplace, self._plan, *common, seeds[2]),
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
            # The last takes most: a client of its own, fifty times a second.
            return (
                all(beats(member.pid) for member in self._target.members)
                and judges()
                and all(map(serves, self._servers))
            )

        wait_until(everything, RECOVERS_WITHIN_S, self._logs)
        self._remains.count_descriptors()

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


@contextmanager
def campaign_folder() -> Iterator[Path]:
    """Provide an empty folder, which is removed unless the block fails."""
    folder = Path(tempfile.mkdtemp(prefix="tril-faults-"))
    yield folder
    shutil.rmtree(folder, ignore_errors=True)
