"""Ownership of games in the database: acquiring, saving, branching, releasing, ending.

A game has one owner, a process and a tab. Each acquisition raises the game's epoch and each write
carries one, so that the writes of a former owner are refused.
"""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Callable, Container, Sequence
from contextlib import suppress
from datetime import timedelta
from functools import partial
from typing import TypeVar

from sqlalchemy.orm import Session

from server.play.conditions import PlayConditions
from server.play.consoles import ConsolePool
from server.play.limits import GameLimits
from server.play.replays import ReplayProcess, ReplayTask
from server.play.rules import PlayRules
from server.play.saving.committer import Committer
from server.play.session.live_game import GameInfo, LiveGame
from server.play.session.session import PlaySession, RewoundGame
from server.play.wire.protocol import Paused
from tril.errors import Unavailable
from tril.games.base import Taken
from tril.play.episode import EpisodeState
from tril.recording import Recorder, Recording, RecordingRefused
from tril.store import behaviours, games, recordings
from tril.store.games import GameOver, Progress
from tril.store.models import BehaviourRow, GameRow, RecordingRow, RecordingState

_LOG = logging.getLogger(__name__)

RETRY_S = 1.0
_T = TypeVar("_T")


class OwnershipLost(Exception):
    """Another process owns the game now."""


class GameOwnership:
    """The games that this process owns in the database.

    Args:
        committer: Runs the transactions.
        replays: The process that verifies games.
        consoles: The pool to take consoles from.
        owner: Name of this process.
        limits: Limits on the number of open games.

    Attributes:
        is_stopping: Whether to give up what can't be written instead of retrying.
    """

    def __init__(
        self,
        committer: Committer,
        replays: ReplayProcess,
        consoles: ConsolePool,
        owner: str,
        limits: GameLimits,
    ) -> None:
        self.is_stopping = False
        self._committer = committer
        self._replays = replays
        self._consoles = consoles
        self._owner = owner
        self._limits = limits

    async def check_open(self, game_id: str) -> None:
        """Raise NotFound or GameOver unless the game exists and goes on."""
        row = await self._committer.run(lambda session: games.get(session, game_id))
        if row.ended_at is not None:
            raise GameOver("This game is over.")

    async def acquire(self, game_id: str, tab: str) -> tuple[GameRow, BehaviourRow]:
        """Make this process and a tab the owner of a game; returns it as it was saved last.

        Raises:
            NotFound: There is no such game.
            GameOver: It has ended.
            TooManyGames: It needs a place again, and there is none.
            Unavailable: The database can't be written; says what to do.
        """

        def acquire(session: Session) -> tuple[GameRow, BehaviourRow]:
            had_a_place = games.is_open(session, game_id)
            row = games.acquire(session, game_id, self._owner, tab)
            if not had_a_place:
                self._limits.check(session, row.recording.player_id, n_counted=1)
            return row, session.get_one(BehaviourRow, row.recording.behaviour_id)

        return await self._committer.run(acquire)

    async def load(self, row: GameRow, behaviour: BehaviourRow) -> LiveGame:
        """Rebuild a game by replaying what is saved of it.

        Raises:
            GameOver: The replay differs from what is saved; the game was ended.
        """
        try:
            recording = recordings.as_recording(row.recording)
            recorder = await asyncio.to_thread(self._rebuild, recording)
        except RecordingRefused as error:
            refusal = str(error)
            await self._committer.run(
                lambda session: games.end(
                    session, row.id, row.epoch, RecordingState.UNFINISHED, refusal
                )
            )
            raise GameOver("This game can't go on: it does not replay.") from error
        info = GameInfo(row.id, row.recording_id, behaviours.as_behaviour(behaviour))
        conditions = PlayConditions.from_conditions(row.recording.conditions) or PlayConditions()
        return LiveGame(info, row.epoch, recorder, conditions)

    async def save(self, batch: Sequence[LiveGame]) -> list[LiveGame]:
        """Save games in one transaction; returns those that another process owns now.

        Raises:
            Unavailable: Nothing could be saved; says what to do.
        """
        progresses = [game.progress() for game in batch]
        saved = await self._committer.run(
            lambda session: [games.save(session, progress) for progress in progresses]
        )
        lost = []
        for game, progress, is_saved in zip(batch, progresses, saved, strict=True):
            if is_saved:
                game.mark_saved(progress)
            elif game.epoch == progress.epoch:
                lost.append(game)
        return lost

    async def finish(self, session: PlaySession) -> str | None:
        """Save a game's end and verify it; returns how its replay differs, None if it does not.

        Raises:
            OwnershipLost: Another process owns the game now.
            Unavailable: The process stops before this could be done.
        """
        game = session.game
        last = game.progress()
        await self._write(session, lambda: partial(games.save, progress=game.progress()))
        refusal = await find_refusal(
            self._replays, last.recording, last.played.taken, lambda: self.is_stopping
        )
        await self._write(
            session,
            lambda: partial(
                games.end,
                game_id=session.game_id,
                epoch=game.epoch,
                state=RecordingState.FINISHED,
                refusal=refusal,
            ),
        )
        return refusal

    async def branch(self, session: PlaySession, frame: int) -> RewoundGame | None:
        """Keep a game as it was played, and rebuild it up to the frame at which it resumes.

        Returns:
            The rebuilt game; None if the session has to stop before this was done.

        Raises:
            OwnershipLost: Another process owns the game now.
            Conflict: The player may not store more recordings.
        """
        game = session.game
        before = game.progress()
        recorder = await asyncio.to_thread(
            self._rebuild, before.recording.until(frame), game.checkpoints.latest_until(frame)
        )
        row: RecordingRow | None = None
        try:
            with suppress(Unavailable):
                refusal = await find_refusal(
                    self._replays,
                    before.recording,
                    before.played.taken,
                    lambda: session.is_stopping,
                )
                if not session.is_stopping:
                    row = await self._write(
                        session,
                        lambda: partial(
                            self._branch,
                            before=game.progress(),
                            after=game.progress_after_rewind(recorder),
                            refusal=refusal,
                        ),
                    )
        finally:
            if row is None:
                self._consoles.give_back(recorder.episode.console)
        return None if row is None else RewoundGame(recorder, row.id)

    async def release(self, game: LiveGame) -> None:
        """Let a game's lease expire, so that it counts as left alone from now on."""
        with suppress(Unavailable):
            await self._committer.run(
                lambda session: games.release(session, game.info.game_id, game.epoch)
            )

    async def clear_up(self, rules: PlayRules, loaded: Container[str]) -> None:
        """End abandoned games, and keep finished ones that nobody decided about.

        Args:
            rules: Rules with the time limits.
            loaded: Games in this process, which are left alone.
        """
        await self._committer.run(
            lambda session: games.keep_undecided(session, rules.decided_after)
        )
        for row in await self._committer.run(
            lambda session: games.abandoned(session, rules.abandoned_after)
        ):
            if row.id not in loaded:
                await self.end_abandoned(row.id, rules.abandoned_after)

    async def end_abandoned(self, game_id: str, after: timedelta) -> None:
        """End a game as an unfinished recording if nobody has owned it for some time."""
        row = await self._committer.run(
            lambda session: games.acquire_abandoned(session, game_id, self._owner, after)
        )
        if row is None:
            return
        recording = recordings.as_recording(row.recording)
        refusal = await find_refusal(
            self._replays, recording, recordings.taken_of(row.recording), lambda: True
        )
        was_finished = row.recording.end is not None
        state = RecordingState.KEPT if was_finished else RecordingState.UNFINISHED
        await self._committer.run(
            lambda session: games.end(session, game_id, row.epoch, state, refusal)
        )

    def _branch(
        self, session: Session, before: Progress, after: Progress, refusal: str | None
    ) -> RecordingRow | None:
        player = games.player_of(session, before.game_id)
        self._limits.check_recordings(session, None if player is None else player[0])
        return games.branch(session, before, after, refusal)

    def _rebuild(self, recording: Recording, nearest_state: EpisodeState | None = None) -> Recorder:
        console = self._consoles.take(recording.game)
        try:
            return Recorder.resume(recording, console, nearest_state=nearest_state)
        except BaseException:
            self._consoles.give_back(console)
            raise

    async def _write(
        self, session: PlaySession, prepare: Callable[[], Callable[[Session], _T]]
    ) -> _T:
        """Write as a game's owner; retries while the database can't be written.

        It gives up when the process or the session is to stop: whoever waits for the latter may
        hold the lock of those who join.

        Args:
            session: The game's session; its page is told why it waits.
            prepare: Returns the transaction, which returns something false if it was refused.

        Raises:
            OwnershipLost: Another process owns the game now.
            Unavailable: Gave up.
        """
        while True:
            epoch = session.game.epoch
            try:
                written = await self._committer.run(prepare())
            except Unavailable as error:
                if self.is_stopping or session.is_stopping:
                    raise
                await session.send(Paused(why=str(error)))
                await asyncio.sleep(RETRY_S)
                continue
            if written:
                return written
            # A join in this process raises the epoch as well, and has noted it before this resumes.
            if session.game.epoch == epoch:
                raise OwnershipLost


async def find_refusal(
    replays: ReplayProcess,
    recording: Recording,
    taken: tuple[Taken, ...],
    give_up: Callable[[], bool],
) -> str | None:
    """Replay a recording; returns how the replay differs from the game, None if it does not.

    Args:
        replays: The replay process.
        recording: Recording of the game.
        taken: The items taken.
        give_up: Asked after each failure to replay whether to raise instead of retrying.

    Raises:
        Unavailable: The recording could not be replayed.
    """
    cells = [item.cell for item in taken]
    while True:
        try:
            await asyncio.wrap_future(replays.submit(ReplayTask.CHECK, recording, cells))
        except RecordingRefused as error:
            _LOG.error("A game does not replay: %s", error)
            return str(error)
        except Unavailable:
            if give_up():
                raise
            await asyncio.sleep(RETRY_S)
        else:
            return None
