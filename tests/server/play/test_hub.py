"""Games that are joined, left, unloaded and lost at once, against what may be held by whom."""

from __future__ import annotations

import asyncio
import tempfile
from collections import deque
from collections.abc import Callable, Iterator
from concurrent.futures import Future
from dataclasses import dataclass, field
from datetime import timedelta
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, settings
from hypothesis import strategies as st
from hypothesis.stateful import (
    RuleBasedStateMachine,
    initialize,
    invariant,
    rule,
    run_state_machine_as_test,
)
from sqlalchemy.orm import Session

from server.play.consoles import ConsolePool
from server.play.hub import PlayHub
from server.play.limits import GameLimits
from server.play.replays import ReplayProcess
from server.play.rules import PlayRules
from server.play.saving import ownership
from server.play.saving.committer import Committer
from server.play.session.session import PlaySession
from server.play.wire.connection import Connection
from server.play.wire.protocol import Command
from testsupport.workplace import Workplace, make_workplace
from tril.errors import TrilError
from tril.games.atari.starts import AtariStart
from tril.games.space_invaders import SPACE_INVADERS
from tril.store import games, players

RULES = PlayRules(
    countdown=0,
    forgotten_after_s=-1.0,
    idle_after=timedelta(seconds=-1),
    sweep_every_s=3600.0,
    save_every_s=3600.0,
    max_games=2,
)
"""What nobody plays is unloaded by the next sweep, and a third game needs another's place."""

N_GAMES = 3
N_CONSOLES = 6


class Transactions(Committer):
    """Transactions that are executed one after the other, each when the test says so."""

    def __init__(self, committer: Committer) -> None:
        self._committer = committer
        self.waiting: deque[tuple[Callable[[Session], Any], asyncio.Future[Any]]] = deque()

    async def run(self, work: Callable[[Session], Any]) -> Any:
        done = asyncio.get_running_loop().create_future()
        self.waiting.append((work, done))
        return await done

    def close(self) -> None:
        self._committer.close()

    def execute_next(self) -> None:
        work, done = self.waiting.popleft()
        try:
            done.set_result(self._committer._transact(work))
        except TrilError as error:
            done.set_exception(error)


class Verified(ReplayProcess):
    """Finds that every game replays."""

    def prepare(self) -> None:
        """Start nothing."""

    def submit(self, *_asked: object) -> Future[bytes]:
        future: Future[bytes] = Future()
        future.set_result(b"")
        return future


class Page:
    """A page's socket, which closes when the server closes it."""

    async def send_bytes(self, data: bytes) -> None:
        await asyncio.sleep(0)

    async def send_text(self, data: str) -> None:
        await asyncio.sleep(0)

    async def close(self, code: int = 1000, reason: str | None = None) -> None:
        await asyncio.sleep(0)


@dataclass
class Joining:
    """Somebody who joins a game, or has joined it.

    Attributes:
        game_id: The game.
        connection: Their page.
        task: The join.
    """

    game_id: str
    connection: Connection
    task: asyncio.Task[PlaySession]

    @property
    def session(self) -> PlaySession | None:
        """What they joined; None as long as they have not, or if they could not."""
        if not self.task.done() or self.task.cancelled() or self.task.exception() is not None:
            return None
        return self.task.result()


@dataclass
class HubUnderTest:
    """A hub whose transactions wait, in an event loop that runs only on demand.

    Attributes:
        workplace: Its data folder.
        loop: Its event loop.
        consoles: Its pool.
        hub: The hub.
        transactions: What it does with the database.
        game_ids: Games that can be joined.
        joining: Those who joined.
        tasks: Sweeps and the like under way.
    """

    workplace: Workplace
    loop: asyncio.AbstractEventLoop
    consoles: ConsolePool
    hub: PlayHub
    transactions: Transactions
    game_ids: list[str]
    joining: list[Joining] = field(default_factory=list)
    tasks: list[asyncio.Task[None]] = field(default_factory=list)

    def settle(self) -> None:
        """Run the event loop until all wait for transactions."""

        async def rest() -> None:
            for _ in range(40):
                await asyncio.sleep(0)

        self.loop.run_until_complete(rest())

    def join(self, game: int) -> Joining:
        connection = Connection(Page())
        game_id = self.game_ids[game]
        task = self.loop.create_task(self.hub.join(game_id, f"tab-{len(self.joining)}", connection))
        self.joining.append(Joining(game_id, connection, task))
        self.settle()
        return self.joining[-1]

    def begin(self, work: Any) -> None:
        self.tasks.append(self.loop.create_task(work))
        self.settle()

    def sweep(self) -> None:
        self.begin(self.hub._unload_idle())

    def leave(self, joined: Joining) -> None:
        session = joined.session
        assert session is not None
        joined.connection.is_open = False
        self.begin(session.detach(joined.connection))

    def execute(self, n_transactions: int = 1) -> None:
        for _ in range(n_transactions):
            if self.transactions.waiting:
                self.transactions.execute_next()
            self.settle()

    def drain(self) -> None:
        while self.transactions.waiting:
            self.execute()

    def steal(self, game: int) -> None:
        """Make another process the owner of a game."""
        with self.workplace.database.writing() as session:
            if games.get(session, self.game_ids[game]).ended_at is None:
                games.acquire(session, self.game_ids[game], "another process", "its tab")

    def check(self) -> None:
        """Check that no console has two users, and that nobody plays what the hub forgot."""
        held = [session.game.episode.console for session in self.hub._sessions.values()]
        used = {id(console) for console in held}
        assert len(used) == len(held)
        assert not used & {id(console) for console in self.consoles._idle}
        assert len({id(console) for console in self.consoles._idle}) == len(self.consoles._idle)
        for joined in self.joining:
            session = joined.session
            if session is not None and joined.connection.is_open:
                assert self.hub._sessions.get(joined.game_id) is session
                assert session.connection is joined.connection
        for task in self.tasks:
            if task.done():
                task.result()

    def end(self) -> None:
        """Let all leave, and check that no console was lost."""
        self.drain()
        for joined in self.joining:
            assert joined.task.done()
            error = joined.task.exception()
            assert error is None or isinstance(error, TrilError), error
            if joined.session is not None and joined.connection.is_open:
                self.leave(joined)
        self.drain()
        self.sweep()
        self.drain()
        self.check()
        assert not self.hub._sessions
        assert not self.hub._joining
        assert len(self.consoles._idle) == self.consoles.n_loaded


_LOADED = ConsolePool()


def start(folder: Path) -> HubUnderTest:
    """Make a hub; consoles are loaded once for all."""
    workplace = make_workplace(folder)
    with workplace.database.writing() as session:
        person = players.owner(session).id
        made = [
            games.create(session, workplace.behaviour_id, AtariStart(0), person).id
            for _ in range(N_GAMES)
        ]
    while _LOADED.n_loaded < N_CONSOLES:
        _LOADED.give_back(_LOADED._load(SPACE_INVADERS))
    limits = GameLimits(total=100, per_player=100)
    hub = PlayHub(workplace.database, _LOADED, Verified(), "this process", RULES, limits)
    transactions = Transactions(hub._committer)
    hub._committer = hub._ownership._committer = transactions
    loop = asyncio.new_event_loop()
    return HubUnderTest(workplace, loop, _LOADED, hub, transactions, made)


@pytest.fixture(autouse=True)
def _threads_work_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    async def at_once(work: Callable[..., Any], *arguments: Any) -> Any:
        return work(*arguments)

    monkeypatch.setattr(asyncio, "to_thread", at_once)
    monkeypatch.setattr(ownership, "RETRY_S", 0.0)


@pytest.fixture
def under_test(tmp_path: Path) -> Iterator[HubUnderTest]:
    made = start(tmp_path / "data")
    yield made
    made.end()
    close(made)


def close(made: HubUnderTest) -> None:
    made.hub._committer.close()
    made.loop.close()
    made.workplace.database.close()


def joined(made: HubUnderTest, game: int = 0) -> Joining:
    """Let somebody join."""
    page = made.join(game)
    made.drain()
    assert page.session is not None
    return page


def test_a_sweep_leaves_a_game_alone_that_is_being_joined(under_test: HubUnderTest) -> None:
    under_test.leave(joined(under_test))
    again = under_test.join(0)
    under_test.sweep()
    under_test.drain()
    under_test.check()
    assert again.connection.is_open
    joined(under_test, game=1)
    under_test.check()


def test_a_game_that_is_joined_while_it_is_unloaded_is_loaded_again(
    under_test: HubUnderTest,
) -> None:
    first = joined(under_test)
    under_test.leave(first)
    under_test.sweep()
    again = under_test.join(0)
    under_test.drain()
    under_test.check()
    assert again.session is not first.session


def test_an_idle_game_that_is_joined_while_it_is_closed_is_not_played_on(
    under_test: HubUnderTest,
) -> None:
    first = joined(under_test)
    under_test.sweep()
    again = under_test.join(0)
    under_test.drain()
    under_test.check()
    assert not first.connection.is_open
    # It ended; the page is told, instead of being left before a game that never moves.
    assert isinstance(again.task.exception(), games.GameOver)


def test_two_who_need_a_place_unload_two_games(under_test: HubUnderTest) -> None:
    for game in (0, 1):
        under_test.leave(joined(under_test, game))
    third, again = under_test.join(2), under_test.join(0)
    under_test.drain()
    under_test.check()
    assert third.session is not None
    assert again.session is not None
    assert under_test.hub.n_games <= RULES.max_games


def test_a_game_that_fails_while_it_is_joined_is_loaded_again(under_test: HubUnderTest) -> None:
    first = joined(under_test)
    session = first.session
    assert session is not None

    async def fail() -> None:
        await session._activity.stop_requested.wait()
        raise RuntimeError("the emulator broke")

    under_test.loop.call_soon(lambda: session._activity.start(fail()))
    again = under_test.join(0)
    under_test.drain()
    under_test.check()
    assert again.session is not session
    assert again.connection.is_open


def test_a_console_is_given_back_once(under_test: HubUnderTest) -> None:
    console = under_test.consoles.take(SPACE_INVADERS)
    under_test.consoles.give_back(console)
    with pytest.raises(ValueError, match="idle"):
        under_test.consoles.give_back(console)


class Hub(RuleBasedStateMachine):
    """Any order of joins, leaves, sweeps, saves, losses and commits."""

    @initialize()
    def begin(self) -> None:
        self.folder = tempfile.TemporaryDirectory()
        self.made = start(Path(self.folder.name) / "data")

    @rule(game=st.integers(0, N_GAMES - 1))
    def somebody_joins(self, game: int) -> None:
        self.made.join(game)

    @rule(number=st.integers(0, 7))
    def somebody_leaves(self, number: int) -> None:
        here = [one for one in self.made.joining if one.session and one.connection.is_open]
        if here:
            self.made.leave(here[number % len(here)])

    @rule(number=st.integers(0, 7))
    def a_frame_is_played(self, number: int) -> None:
        here = [one for one in self.made.joining if one.session and one.connection.is_open]
        if here:
            session = here[number % len(here)].session
            assert session is not None
            self.made.begin(session.handle(Command(type="step")))

    @rule(number=st.integers(0, 7))
    def a_game_is_stopped(self, number: int) -> None:
        here = [one for one in self.made.joining if one.session and one.connection.is_open]
        if here:
            session = here[number % len(here)].session
            assert session is not None
            self.made.begin(session.handle(Command(type="stop")))

    @rule()
    def idle_games_are_unloaded(self) -> None:
        self.made.sweep()

    @rule()
    def games_are_saved(self) -> None:
        for session in self.made.hub._sessions.values():
            session.save_tried_at = float("-inf")
        self.made.begin(self.made.hub._save_due())

    @rule(game=st.integers(0, N_GAMES - 1))
    def another_process_takes_a_game(self, game: int) -> None:
        self.made.steal(game)

    @rule(n_transactions=st.integers(1, 3))
    def transactions_are_executed(self, n_transactions: int) -> None:
        self.made.execute(n_transactions)

    @invariant()
    def nothing_is_shared(self) -> None:
        if hasattr(self, "made"):
            self.made.check()

    def teardown(self) -> None:
        if hasattr(self, "made"):
            self.made.end()
            close(self.made)
            self.folder.cleanup()


def test_no_console_is_held_by_two_or_lost_in_any_order() -> None:
    run_state_machine_as_test(
        Hub,
        settings=settings(
            max_examples=25,
            stateful_step_count=25,
            suppress_health_check=[HealthCheck.too_slow, HealthCheck.filter_too_much],
            derandomize=True,
        ),
    )
