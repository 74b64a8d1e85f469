"""All games of this process: who joins which, when they are saved, and what becomes of them."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import asynccontextmanager, suppress
from datetime import timedelta
from functools import partial
from weakref import WeakValueDictionary

from sqlalchemy.orm import Session

from server.play.conditions import PlayConditions
from server.play.consoles import ConsolePool
from server.play.lateness import Complaints, Lateness
from server.play.limits import GameLimits, TooManyGames
from server.play.replays import ReplayProcess
from server.play.rules import PlayRules
from server.play.saving.checks import Checks
from server.play.saving.committer import Committer
from server.play.saving.save_schedule import TURNS, whose_turn
from server.play.session.session import Branched, Phase, PlaySession
from server.play.wire.connection import Connection
from server.play.wire.protocol import Paused
from tril.errors import Unavailable
from tril.game.episode import EpisodeState
from tril.recording import Recorder, Recording, RecordingRefused
from tril.store import behaviours, games, recordings
from tril.store.database import Database
from tril.store.games import Progress
from tril.store.models import BehaviourRow, GameRow, RecordingState

_LOG = logging.getLogger(__name__)

N_SPARE_CONSOLES = 2
"""Consoles beside those of the games, to replay and to run back on."""
WHY_IDLE = "Nobody played on for long; what was played is kept."
REPORT_EVERY_S = 60.0
RETRY_S = 1.0
JOINING_S = 0.02


class PlayHub:
    """The games that are played in this process.

    Attributes:
        lateness: How late their frames began, ever since the process started.

    Args:
        database: Where games are kept.
        consoles: Where consoles to play on come from.
        replays: What checks the recordings.
        owner: Name of this process.
        rules: The times to keep.
        limits: How many games may be open over all processes.
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
        self._limits = limits
        self.lateness = Lateness()
        self._complaints = Complaints(self.lateness)
        self._consoles = consoles
        self._checks = Checks(replays)
        self._owner = owner
        self._rules = rules
        self._committer = Committer(database)
        self._sessions: dict[str, PlaySession] = {}
        self._arriving: set[str] = set()
        self._joining: WeakValueDictionary[str, asyncio.Lock] = WeakValueDictionary()
        self._tasks: list[asyncio.Task[None]] = []
        self._is_stopping = False

    def start(self) -> None:
        """Begin to save games and to look after those that were left alone."""
        self._tasks = [
            asyncio.create_task(self._every(self._rules.save_every_s / TURNS, self._save_some)),
            asyncio.create_task(self._every(self._rules.sweep_every_s, self._sweep, at_once=True)),
            asyncio.create_task(self._every(REPORT_EVERY_S, self._report)),
        ]

    async def stop(self) -> None:
        """Save every game and let go of it; it goes on in whichever process it is joined next."""
        self._is_stopping = True
        for task in self._tasks:
            task.cancel()
        await asyncio.gather(*self._tasks, return_exceptions=True)
        sessions = list(self._sessions.values())
        await asyncio.gather(*(session.settle() for session in sessions))
        for session in list(self._sessions.values()):
            await self._let_go(session)
        self._committer.close()

    async def join(self, game_id: str, tab: str, connection: Connection) -> PlaySession:
        """Make a tab the player of a game; whoever had it before is told.

        Raises:
            NotFound: There is no such game.
            GameOver: It has ended.
            Unavailable: It could not be taken over, or too many games are open; says what to do.
        """
        lock = self._joining.setdefault(game_id, asyncio.Lock())
        async with lock, self._place_for(game_id):
            row, behaviour = await self._committer.run(
                lambda session: self._claim(session, game_id, tab)
            )
            session = self._sessions.get(game_id)
            if session is not None and session.epoch == row.epoch - 1:
                session.epoch = row.epoch
            else:
                if session is not None:
                    await self._lose(session)
                session = await self._resume(row, behaviour)
            is_resumed = session.recorder.episode.frame > 0
            self._checks.prepare()
            await session.attach(connection, is_resumed)
            return session

    @asynccontextmanager
    async def _place_for(self, game_id: str) -> AsyncIterator[None]:
        """Keep a place for a game that arrives, if need be by letting go of one without a page."""
        self._arriving.add(game_id)
        try:
            taken = self._sessions.keys() | self._arriving
            if len(taken) > self._rules.max_games and game_id not in self._sessions:
                await self._make_room()
            yield
        finally:
            self._arriving.remove(game_id)

    async def _make_room(self) -> None:
        left = [
            session
            for session in self._sessions.values()
            if session.connection is None
            and session.phase is Phase.WAITING
            and session.game_id not in self._arriving
        ]
        if not left:
            raise TooManyGames("This process plays as many games as it can; join again.")
        await self._let_go(min(left, key=lambda session: session.left_at))

    def _claim(self, session: Session, game_id: str, tab: str) -> tuple[GameRow, BehaviourRow]:
        had_a_place = games.is_open(session, game_id)
        row = games.claim(session, game_id, self._owner, tab)
        if not had_a_place:
            self._limits.check(session, row.recording.player_id, n_counted=1)
        return row, session.get_one(BehaviourRow, row.recording.behaviour_id)

    async def _resume(self, row: GameRow, behaviour: BehaviourRow) -> PlaySession:
        """Rebuild a game by replaying what is saved of it."""
        recording = recordings.as_recording(row.recording)
        try:
            recorder = await asyncio.to_thread(self._rebuild, recording)
        except RecordingRefused as error:
            refusal = str(error)
            await self._committer.run(
                lambda session: games.end(
                    session, row.id, row.epoch, RecordingState.UNFINISHED, refusal
                )
            )
            raise games.GameOver("This game can't go on: it does not replay.") from error
        session = PlaySession(
            game_id=row.id,
            recording_id=row.recording_id,
            behaviour=behaviours.as_behaviour(behaviour),
            recorder=recorder,
            epoch=row.epoch,
            conditions=PlayConditions.from_conditions(row.recording.conditions) or PlayConditions(),
            consoles=self._consoles,
            rules=self._rules,
            lateness=self.lateness,
            branch=self._branch,
            finish=self._finish,
        )
        self._sessions[row.id] = session
        return session

    def _rebuild(self, recording: Recording, near: EpisodeState | None = None) -> Recorder:
        return Recorder.resume(recording, self._consoles.take(), near=near)

    async def _save_some(self) -> None:
        """Save the games whose turn it is.

        A commit's work in its thread takes Python's lock from the event loop for about a
        millisecond a game, which is little for some games and a frame and more for all.
        """
        now = asyncio.get_running_loop().time()
        last = {
            session: session.save_tried_at
            for session in self._sessions.values()
            if session.is_dirty and session.phase is not Phase.ENDED
        }
        batch = {}
        for session in whose_turn(last, now, self._rules.save_every_s):
            session.save_tried_at = now
            batch[session.game_id] = (session, session.progress())
        if not batch:
            return
        try:
            saved = await self._committer.save([progress for _, progress in batch.values()])
        except Unavailable as error:
            for session, _ in batch.values():
                await session.pause(str(error))
            return
        for progress in saved:
            batch.pop(progress.game_id)[0].note_saved(progress)
        for session, progress in batch.values():
            # A join in this process raises the epoch while a commit is under way; that is no loss.
            if not self._is_joining(session.game_id) and session.epoch == progress.epoch:
                await self._lose(session)

    async def _finish(self, session: PlaySession) -> None:
        """Save a game's end, check it by a replay, and tell the player."""
        progress = session.progress()
        if not await self._insist(
            session, lambda transaction: games.save(transaction, session.progress())
        ):
            return
        try:
            refusal = await self._checks.refusal(
                progress.recording, progress.played.hits, lambda: self._is_stopping
            )
        except Unavailable:
            return  # the process ends, and the game is over for whoever joins it next
        if await self._insist(
            session,
            lambda transaction: games.end(
                transaction, session.game_id, session.epoch, RecordingState.FINISHED, refusal
            ),
        ):
            await session.tell_ended(refusal)
            self._forget(session)

    async def _branch(self, session: PlaySession, frame: int) -> Branched | None:
        """Keep a game as it was played, and rebuild it up to a frame from which it goes on."""
        before = session.progress()
        near = session.tape.state_before(frame)
        recorder = await asyncio.to_thread(self._rebuild, before.recording.until(frame), near)
        kept = None
        with suppress(Unavailable):
            refusal = await self._checks.refusal(
                before.recording, before.played.hits, lambda: session.is_halting
            )
            kept = await self._keep_branch(session, recorder, refusal)
        if kept is None:
            self._consoles.give_back(recorder.episode.console)
            return None
        return Branched(recorder, kept)

    async def _keep_branch(
        self, session: PlaySession, recorder: Recorder, refusal: str | None
    ) -> int | None:
        """Write a branch as a game's owner; returns the recording that was kept.

        Unlike the end of a game this is given up when the game is to stand still: whoever waits
        for that may hold the lock of those who join.
        """
        while not session.is_halting:
            epoch = session.epoch
            before, after = session.progress(), session.progress_until(recorder)
            try:
                kept = await self._committer.run(partial(_write_branch, before, after, refusal))
            except Unavailable as error:
                if session.connection is not None:
                    await session.connection.tell(Paused(why=str(error)))
                await asyncio.sleep(RETRY_S)
                continue
            if kept is not None:
                return kept
            if session.epoch == epoch and not self._is_joining(session.game_id):
                await self._lose(session)
                return None
            await asyncio.sleep(JOINING_S)
        return None

    async def _insist(self, session: PlaySession, write: Callable[[Session], bool]) -> bool:
        """Write as a game's owner, however long the disk is full; returns whether it was written.

        A game that is another owner's by now is given up, and so is every try when the process
        ends.
        """
        while True:
            epoch = session.epoch
            try:
                if await self._committer.run(write):
                    return True
            except Unavailable as error:
                if self._is_stopping:
                    return False
                if session.connection is not None:
                    await session.connection.tell(Paused(why=str(error)))
                await asyncio.sleep(RETRY_S)
                continue
            async with self._joining.setdefault(session.game_id, asyncio.Lock()):
                if session.epoch == epoch:
                    await self._lose(session)
                    return False

    async def _report(self) -> None:
        """Say in the log when games are not played at their times."""
        complaint = self._complaints.since_last(len(self._sessions))
        if complaint is not None:
            _LOG.warning("%s", complaint)

    async def _sweep(self) -> None:
        """Look after games that were left alone."""
        now = asyncio.get_running_loop().time()
        for session in list(self._sessions.values()):
            if session.phase is not Phase.WAITING:
                continue
            if session.connection is not None:
                if now - session.still_since > self._rules.idle_after.total_seconds():
                    await self._end_idle(session)
                else:
                    await self._release(session)
            elif now - session.left_at > self._rules.forgotten_after_s:
                await self._let_go(session)
        await self._committer.run(
            lambda session: games.keep_undecided(session, self._rules.decided_after)
        )
        for row in await self._committer.run(
            lambda session: games.abandoned(session, self._rules.abandoned_after)
        ):
            if row.id not in self._sessions:
                await self._end_abandoned(row.id, self._rules.abandoned_after)

    async def _end_idle(self, session: PlaySession) -> None:
        """End a game that stands still before its page, which is told; not one to be saved yet."""
        if session.is_dirty:
            return
        await session.say_over(WHY_IDLE)
        await self._let_go(session)
        await self._end_abandoned(session.game_id, timedelta(0))

    async def _end_abandoned(self, game_id: str, after: timedelta) -> None:
        """Turn a game that nobody has had for so long into an unfinished recording."""
        row = await self._committer.run(
            lambda session: games.claim_abandoned(session, game_id, self._owner, after)
        )
        if row is None:
            return
        recording = recordings.as_recording(row.recording)
        refusal = await self._checks.refusal(
            recording, recordings.hits_of(row.recording), lambda: True
        )
        was_played = row.recording.end is not None
        state = RecordingState.KEPT if was_played else RecordingState.UNFINISHED
        await self._committer.run(
            lambda session: games.end(session, game_id, row.epoch, state, refusal)
        )

    async def _let_go(self, session: PlaySession) -> None:
        """Save a game and forget it here; what is saved is what it goes on from."""
        try:
            if session.is_dirty:
                await self._committer.save([session.progress()])
        except Unavailable as error:
            _LOG.error("The last second of game %s is lost: %s", session.game_id, error)
            if not self._is_stopping:
                return
        await self._release(session)
        self._forget(session)

    async def _release(self, session: PlaySession) -> None:
        with suppress(Unavailable):
            await self._committer.run(
                lambda transaction: games.release(transaction, session.game_id, session.epoch)
            )

    async def _lose(self, session: PlaySession) -> None:
        """Give a game up that is another process's now."""
        self._forget(session)
        await session.give_up()

    def _forget(self, session: PlaySession) -> None:
        if self._sessions.get(session.game_id) is session:
            del self._sessions[session.game_id]
            self._consoles.give_back(session.recorder.episode.console)

    def _is_joining(self, game_id: str) -> bool:
        lock = self._joining.get(game_id)
        return lock is not None and lock.locked()

    async def _every(
        self, period_s: float, work: Callable[[], Awaitable[None]], at_once: bool = False
    ) -> None:
        """Do something again and again at absolute times."""
        loop = asyncio.get_running_loop()
        due = loop.time() + (0.0 if at_once else period_s)
        while True:
            await asyncio.sleep(max(0.0, due - loop.time()))
            try:
                await work()
            except Unavailable as error:
                _LOG.warning("%s", error)
            due = max(due + period_s, loop.time())


def _write_branch(
    before: Progress, after: Progress, refusal: str | None, session: Session
) -> int | None:
    row = games.branch(session, before, after, refusal)
    return None if row is None else row.id
