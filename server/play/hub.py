"""All games of this process: joining, saving periodically, unloading."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import AsyncIterator, Collection
from contextlib import asynccontextmanager
from datetime import timedelta
from weakref import WeakValueDictionary

from server.play.background import PeriodicTask
from server.play.consoles import ConsolePool
from server.play.lateness import Lateness, LatenessLog
from server.play.limits import GameLimits, TooManyGames
from server.play.replays import ReplayProcess
from server.play.rules import PlayRules
from server.play.saving.committer import Committer
from server.play.saving.ownership import GameOwnership, OwnershipLost
from server.play.saving.save_schedule import N_SLOTS, games_due
from server.play.session.session import (
    WHY_TAKEN_OVER,
    Phase,
    PlaySession,
    RewoundGame,
    SessionEvents,
    SessionResources,
)
from server.play.wire.connection import Connection
from server.play.wire.protocol import Close, ServerMessage, TakenOver
from tril.errors import Conflict, Unavailable
from tril.store.database import Database

_LOG = logging.getLogger(__name__)

N_SPARE_CONSOLES = 2
"""Consoles beside those of the games, to rebuild and rewind on."""
WHY_IDLE = "Nobody played on for long; what was played is kept."
WHY_FAILED = "An error stopped the game; join it again."
REPORT_EVERY_S = 60.0


class PlayHub:
    """The games in this process.

    Args:
        database: Where games are saved.
        consoles: The pool to take consoles from.
        replays: The process that verifies recordings.
        owner: Name of this process.
        rules: Timing.
        limits: Limits on the number of open games, over all processes.

    Attributes:
        lateness: Lateness of frames since the process started.
    """

    def __init__(
        self,
        database: Database,
        consoles: ConsolePool,
        replays: ReplayProcess,
        owner: str,
        rules: PlayRules,
        limits: GameLimits,
    ) -> None:
        self.lateness = Lateness()
        self._consoles = consoles
        self._replays = replays
        self._rules = rules
        self._watched = limits.watched
        self._committer = Committer(database)
        self._ownership = GameOwnership(self._committer, replays, consoles, owner, limits)
        self._resources = SessionResources(consoles, rules, self.lateness)
        self._events = SessionEvents(self._on_rewind, self._on_end, self._on_error)
        self._sessions: dict[str, PlaySession] = {}
        self._joining: set[str] = set()
        # Held by who joins a game and by who unloads it, but not within the session's own task,
        # which a join waits for.
        self._locks: WeakValueDictionary[str, asyncio.Lock] = WeakValueDictionary()
        self._lateness_log = LatenessLog(self.lateness)
        self._tasks = (
            PeriodicTask("save", self._save_due, rules.save_every_s / N_SLOTS),
            PeriodicTask("idle", self._unload_idle, rules.sweep_every_s),
            PeriodicTask("abandoned", self._remove_abandoned, rules.sweep_every_s, at_once=True),
            PeriodicTask("lateness", self._report_lateness, REPORT_EVERY_S),
        )

    @property
    def background_tasks(self) -> Collection[PeriodicTask]:
        """The tasks that save and clear up, with their health."""
        return self._tasks

    @property
    def n_games(self) -> int:
        """Number of games in this process, those being joined included."""
        return len(self._sessions.keys() | self._joining)

    def start(self) -> None:
        """Start saving games and clearing up those that were left alone."""
        for task in self._tasks:
            task.start()

    async def stop(self) -> None:
        """Save and release every game; it goes on in the process that it is joined in next."""
        self._ownership.is_stopping = True
        await asyncio.gather(*(task.stop() for task in self._tasks))
        await asyncio.gather(*(session.shut_down() for session in self._sessions.values()))
        for session in list(self._sessions.values()):
            async with self._lock_of(session.game_id):
                await self._unload(session)
        self._committer.close()

    async def join(self, game_id: str, tab: str, connection: Connection) -> PlaySession:
        """Make a tab the player of a game; the tab that had it before is told.

        Raises:
            NotFound: There is no such game.
            GameOver: It has ended.
            Unavailable: It can't be loaded, or too many games are open; says what to do.
        """
        async with self._lock_of(game_id):
            if game_id not in self._sessions:
                await self._ownership.check_open(game_id)
            async with self._slot_for(game_id):
                self._replays.prepare()
                while True:
                    session = await self._acquire(game_id, tab)
                    # An error may end the session while it comes to a stand.
                    await session.halt()
                    if self._holds(session):
                        await session.attach(connection)
                        return session

    async def _acquire(self, game_id: str, tab: str) -> PlaySession:
        row, behaviour = await self._ownership.acquire(game_id, tab)
        session = self._sessions.get(game_id)
        if session is not None:
            if session.game.epoch == row.epoch - 1:
                session.game.epoch = row.epoch
                return session
            await self._drop_lost(session)
        game = await self._ownership.load(row, behaviour)
        session = self._sessions[game_id] = PlaySession(game, self._resources, self._events)
        return session

    def _lock_of(self, game_id: str) -> asyncio.Lock:
        return self._locks.setdefault(game_id, asyncio.Lock())

    @asynccontextmanager
    async def _slot_for(self, game_id: str) -> AsyncIterator[None]:
        """Reserve a slot for a game, if need be by unloading a game without a page."""
        self._joining.add(game_id)
        try:
            n_taken = self.n_games + self._watched.n_open
            if n_taken > self._rules.max_games and game_id not in self._sessions:
                await self._unload_longest_left()
            yield
        finally:
            self._joining.remove(game_id)

    async def _unload_longest_left(self) -> None:
        for session in sorted(self._sessions.values(), key=lambda session: session.left_at):
            lock = self._lock_of(session.game_id)
            if not _is_abandoned(session) or lock.locked():
                continue
            async with lock:
                # Somebody may have waited for the lock before.
                is_still_left = _is_abandoned(session) and self._holds(session)
                if is_still_left and await self._unload(session):
                    return
        raise TooManyGames("This process plays as many games as it can; join again.")

    async def _save_due(self) -> None:
        """Save a share of the games.

        A commit takes Python's lock from the event loop for about a millisecond per game, which is
        too much for all games at once.
        """
        now = asyncio.get_running_loop().time()
        tried_at = {
            session: session.save_tried_at
            for session in self._sessions.values()
            if session.needs_saving and session.phase is not Phase.ENDED
        }
        due_sessions = games_due(tried_at, now, self._rules.save_every_s)
        if not due_sessions:
            return
        for session in due_sessions:
            session.save_tried_at = now
        try:
            lost = await self._ownership.save([session.game for session in due_sessions])
        except Unavailable as error:
            for session in due_sessions:
                await session.pause(str(error))
            return
        for session in due_sessions:
            if session.game in lost:
                await self._drop_lost(session)

    async def _unload_idle(self) -> None:
        """End games that stand still before their page, and unload those without one."""
        for session in list(self._sessions.values()):
            lock = self._lock_of(session.game_id)
            # A game that somebody joins does not stand still.
            if not lock.locked():
                async with lock:
                    await self._unload_if_idle(session)

    async def _unload_if_idle(self, session: PlaySession) -> None:
        now = asyncio.get_running_loop().time()
        if session.phase is not Phase.WAITING or not self._holds(session):
            return
        if session.connection is None:
            if now - session.left_at > self._rules.forgotten_after_s:
                await self._unload(session)
        elif now - session.waiting_since <= self._rules.idle_after.total_seconds():
            await self._ownership.release(session.game)
        elif not session.needs_saving:
            await self._drop(session, Close.GAME_OVER, WHY_IDLE)
            await self._ownership.release(session.game)
            await self._ownership.end_abandoned(session.game_id, timedelta(0))

    async def _remove_abandoned(self) -> None:
        await self._ownership.clear_up(self._rules, self._sessions)

    async def _report_lateness(self) -> None:
        self._lateness_log.report(len(self._sessions))

    async def _on_rewind(self, session: PlaySession, frame: int) -> RewoundGame | None:
        try:
            return await self._ownership.branch(session, frame)
        except OwnershipLost:
            await self._drop_lost(session)
        except Conflict as error:
            await session.pause(str(error))
        return None

    async def _on_end(self, session: PlaySession) -> None:
        try:
            refusal = await self._ownership.finish(session)
        except OwnershipLost:
            await self._drop_lost(session)
        except Unavailable as error:
            # The process stops; the game ends where it is joined next.
            _LOG.warning("Game %s was not ended: %s", session.game_id, error)
        else:
            outcome = session.game.outcome(refusal)
            await self._drop(session, Close.GAME_OVER, "The game is over.", outcome)

    async def _on_error(self, session: PlaySession) -> None:
        """Drop a game after an unexpected error; it goes on from what is saved."""
        await self._drop(session, Close.INTERNAL_ERROR, WHY_FAILED)
        await self._ownership.release(session.game)

    async def _unload(self, session: PlaySession) -> bool:
        """Save, release and forget a game that stands still, with its lock held.

        Returns:
            Whether it is gone. It stays if it can't be saved, unless all stops.
        """
        if session.needs_saving:
            try:
                await self._ownership.save([session.game])
            except Unavailable as error:
                _LOG.error("The last second of game %s is lost: %s", session.game_id, error)
                if not self._ownership.is_stopping:
                    return False
        await self._ownership.release(session.game)
        if self._forget(session):
            self._consoles.give_back(session.game.episode.console)
        return True

    async def _drop_lost(self, session: PlaySession) -> None:
        """Drop a game that another process owns now."""
        await self._drop(session, Close.TAKEN_OVER, WHY_TAKEN_OVER, TakenOver())

    async def _drop(
        self,
        session: PlaySession,
        code: Close,
        reason: str,
        last_message: ServerMessage | None = None,
    ) -> None:
        """Forget a game at once, so that nobody joins it, then stop it and close its page."""
        if self._forget(session):
            await session.close(code, reason, last_message)
            self._consoles.give_back(session.game.episode.console)

    def _holds(self, session: PlaySession) -> bool:
        return self._sessions.get(session.game_id) is session

    def _forget(self, session: PlaySession) -> bool:
        """Forget a game; returns whether it was still held, and so who gives its console back."""
        is_held = self._holds(session)
        if is_held:
            del self._sessions[session.game_id]
        return is_held


def _is_abandoned(session: PlaySession) -> bool:
    return session.connection is None and session.phase is Phase.WAITING
