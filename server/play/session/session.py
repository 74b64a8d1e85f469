"""One game in this process: its clock, its player, and what of it is to be saved."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable
from dataclasses import dataclass
from enum import Enum, auto

from server.play.conditions import KEY, PlayConditions
from server.play.consoles import ConsolePool
from server.play.lateness import Lateness
from server.play.rules import PlayRules
from server.play.session.pace import FrameClock, happens_within
from server.play.session.rewind import Tape, run_back
from server.play.wire.connection import Connection
from server.play.wire.messages import all_hits, greeting, hits_after, outcome
from server.play.wire.protocol import Close, Command, Countdown, Paused, Rewound, TakenOver
from server.play.wire.scene import Scene
from tril.behaviours import Behaviour
from tril.game.controls import action_for
from tril.recording import Recorder
from tril.store.games import Progress

WHY_PAUSED = "You paused the game."
WHY_STALLED = (
    "The page stopped drawing, so the game waits. It goes on by itself when the page draws again; "
    "if this happens often, the connection or the machine is too slow."
)


class Phase(Enum):
    """Where a session stands: WAITING for the player, COUNTING down, and so on."""

    WAITING = auto()
    COUNTING = auto()
    PLAYING = auto()
    REWINDING = auto()
    ENDED = auto()


@dataclass(frozen=True)
class Branched:
    """A game that was run back.

    Attributes:
        recorder: The game up to the frame from which it goes on.
        recording_id: The recording of the game as it was.
    """

    recorder: Recorder
    recording_id: int


class PlaySession:
    """A game that this process owns.

    Everything here runs in the event loop; nothing waits for the database.

    Attributes:
        game_id: The game.
        recording_id: The recording that it becomes.
        epoch: This owner's epoch.
        connection: The page that shows it, if one does.
        phase: Where it stands.
        left_at: When its page went, by the event loop's clock.
        still_since: When it came to stand still, by the same.
        save_tried_at: When it was saved last, or tried to be, by the same.

    Args:
        game_id: The game.
        recording_id: The recording that it becomes.
        behaviour: What is being shown; says which hits are on target.
        recorder: The game itself, on a console of its own.
        epoch: This owner's epoch.
        conditions: How it was played so far; goes on here.
        consoles: Where a console to run the game back on comes from.
        rules: The times to keep.
        lateness: Where to note how late its frames begin.
        branch: Called to keep the game as it was and to rebuild it up to a frame, from which it
            goes on; None if that was not possible.
        finish: Called once when the game is over, played to its end or stopped.
    """

    def __init__(
        self,
        game_id: str,
        recording_id: int,
        behaviour: Behaviour,
        recorder: Recorder,
        epoch: int,
        conditions: PlayConditions,
        consoles: ConsolePool,
        rules: PlayRules,
        lateness: Lateness,
        branch: Callable[[PlaySession, int], Awaitable[Branched | None]],
        finish: Callable[[PlaySession], Awaitable[None]],
    ) -> None:
        self.game_id = game_id
        self.recording_id = recording_id
        self.epoch = epoch
        self.connection: Connection | None = None
        self.phase = Phase.WAITING
        self._behaviour = behaviour
        self._recorder = recorder
        self._conditions = conditions
        self._consoles = consoles
        self._rules = rules
        self._lateness = lateness
        self._branch = branch
        self._finish = finish
        self._tape = Tape()
        self._saved = recorder.episode.actions
        self._stopped = asyncio.Event()
        self._released = asyncio.Event()
        self._task: asyncio.Task[None] | None = None
        self._is_stalled = False
        now = asyncio.get_running_loop().time()
        self.left_at = self.still_since = self.save_tried_at = now

    @property
    def recorder(self) -> Recorder:
        """The game itself."""
        return self._recorder

    @property
    def tape(self) -> Tape:
        """What the game is run back on."""
        return self._tape

    @property
    def is_halting(self) -> bool:
        """Whether somebody waits for the game to stand still."""
        return self._stopped.is_set()

    @property
    def is_dirty(self) -> bool:
        """Whether something was played that is not saved and is not about to be as a branch."""
        is_settled = self.phase is not Phase.REWINDING
        return is_settled and self._recorder.episode.actions != self._saved

    def progress(self) -> Progress:
        """What there is to save."""
        return self._progress_of(self._recorder, self._conditions)

    def progress_until(self, recorder: Recorder) -> Progress:
        """What there is to save of the game once it goes on with this recorder."""
        return self._progress_of(recorder, self._conditions.until(recorder.episode.frame))

    def _progress_of(self, recorder: Recorder, conditions: PlayConditions) -> Progress:
        return Progress(
            self.game_id,
            self.epoch,
            recorder.recording(),
            recorder.replay(),
            {KEY: conditions.to_json()},
        )

    def note_saved(self, progress: Progress) -> None:
        """Take note of what is on disk."""
        self._saved = progress.recording.actions

    async def attach(self, connection: Connection, is_resumed: bool) -> None:
        """Show the game to a page; one that showed it before is told and closed."""
        await self._halt()
        self._stand_still()
        self._is_stalled = False
        before, self.connection = self.connection, connection
        if before is not None:
            await _dismiss(before)
        episode = self._recorder.episode
        speed = self._conditions.speed_percent
        await connection.tell(greeting(self._behaviour, episode, self.epoch, is_resumed, speed))
        await self._show()
        if self.phase is Phase.ENDED:
            return
        if episode.end is not None:
            self._end()

    async def detach(self, connection: Connection) -> None:
        """Pause because a page has gone, unless another one shows the game already."""
        if self.connection is not connection:
            return
        self.connection = None
        self.left_at = asyncio.get_running_loop().time()
        await self._halt()

    async def acknowledge(self) -> None:
        """Take note of a drawn frame, and show one that was left out while the page was behind."""
        connection = self.connection
        if connection is None:
            return
        for frame, latency_ms in connection.take_latencies():
            self._conditions.note_press(frame, latency_ms)
        if self.phase in {Phase.PLAYING, Phase.REWINDING}:
            return
        if connection.shown_frame != self._recorder.episode.frame:
            await self._show()
        elif self._is_stalled and not connection.n_unacknowledged:
            self._begin()

    def set_speed(self, percent: int) -> None:
        """Go on at another speed."""
        self._conditions.set_speed(self._recorder.episode.frame, percent)

    async def obey(self, command: Command) -> None:
        """Do what the player asks for; what makes no sense at the moment is passed over."""
        if self.phase is Phase.ENDED:
            return
        match command.type:
            case "ready" | "go_on":
                self._begin()
            case "pause":
                if self.phase is Phase.PLAYING:
                    self._conditions.note_pause(self._recorder.episode.frame)
                await self.pause(WHY_PAUSED)
            case "step":
                await self._step()
            case "rewind":
                await self._rewind()
            case "release":
                self._released.set()
            case "stop":
                await self._halt()
                self._end()

    async def pause(self, why: str) -> None:
        """Let the game stand still and tell the player why."""
        if self.phase is Phase.ENDED:
            return
        await self._halt()
        self._is_stalled = False
        if self.connection is not None:
            await self.connection.tell(Paused(why=why))

    async def give_up(self) -> None:
        """Stop because the game is somebody else's now."""
        await self._halt()
        self.phase = Phase.ENDED
        connection, self.connection = self.connection, None
        if connection is not None:
            await _dismiss(connection)

    async def say_over(self, why: str) -> None:
        """Stop because the game was ended without its player, and tell the page."""
        await self._halt()
        self.phase = Phase.ENDED
        connection, self.connection = self.connection, None
        if connection is not None:
            await connection.close(Close.GAME_OVER, why)

    async def settle(self) -> None:
        """Stop the clock, silently, because the process ends; what has ended is seen through."""
        await self._halt()
        if self.phase is Phase.ENDED and self._task is not None:
            await asyncio.wait([self._task])

    async def tell_ended(self, refusal: str | None) -> None:
        """Tell the player how the game came out, and close."""
        connection = self.connection
        if connection is None:
            return
        await connection.tell(
            outcome(self._behaviour, self._recorder.episode, self.recording_id, refusal)
        )
        await connection.close(Close.GAME_OVER, "The game is over.")

    def _begin(self) -> None:
        """Count down and play, unless the game does already."""
        if self.phase is Phase.WAITING and self._task is None:
            self._is_stalled = False
            self._task = asyncio.create_task(self._go_on(), name=f"game {self.game_id}")

    async def _step(self) -> None:
        """Execute one frame of a game that stands still."""
        connection = self.connection
        if self.phase is not Phase.WAITING or self._task is not None or connection is None:
            return
        self._is_stalled = False
        self._conditions.single_steps.append(self._recorder.episode.frame + 1)
        # As a task, so that whoever halts the game waits until the frame is through.
        self._task = asyncio.create_task(self._tick(connection), name=f"step of {self.game_id}")
        await asyncio.wait([self._task])
        self._task = None
        self._stand_still()
        if self._recorder.episode.end is not None:
            self._end()

    async def _rewind(self) -> None:
        """Run the game back until the player lets go, and go on from there."""
        await self._halt()
        if self.phase is not Phase.WAITING or self._task is not None or self.connection is None:
            return
        self._is_stalled = False
        self._released.clear()
        self._task = asyncio.create_task(
            self._run_back(self.connection), name=f"rewind of {self.game_id}"
        )

    async def _run_back(self, connection: Connection) -> None:
        try:
            self.phase = Phase.REWINDING
            frame = await run_back(
                self._tape,
                self._recorder.recording(),
                self._consoles,
                connection.show,
                lambda: self._stopped.is_set() or self._released.is_set() or not connection.is_open,
            )
            if not self._released.is_set() or self._stopped.is_set():
                return
            if frame < self._recorder.episode.frame:
                branched = await self._branch(self, frame)
                if branched is None:
                    return
                await self._take_up(branched, connection)
        finally:
            self._stand_still()
            self._task = None
        if not self._stopped.is_set():
            self._begin()

    async def _take_up(self, branched: Branched, connection: Connection) -> None:
        """Go on with the game up to an earlier frame."""
        before, self._recorder = self._recorder, branched.recorder
        frame = self._recorder.episode.frame
        self._saved = self._recorder.episode.actions
        self._conditions = self._conditions.until(frame)
        self._tape.cut(frame)
        self._consoles.give_back(before.episode.console)
        hits = all_hits(self._behaviour, self._recorder.episode)
        await connection.tell(Rewound(frame=frame, hits=hits, recording_id=branched.recording_id))

    async def _go_on(self) -> None:
        """Count down, then play until something stops it."""
        try:
            self.phase = Phase.COUNTING
            for seconds in range(self._rules.countdown, 0, -1):
                await self._tell_countdown(seconds)
                if await happens_within(self._stopped, self._rules.countdown_second_s):
                    return
            await self._tell_countdown(0)
            self.phase = Phase.PLAYING
            with self._consoles.undisturbed():
                await self._play()
        finally:
            self._stand_still()
            self._task = None
        if self._recorder.episode.end is not None:
            self._end()
        elif self._is_stalled and self.connection is not None:
            await self.connection.tell(Paused(why=WHY_STALLED))

    async def _play(self) -> None:
        if self.connection is not None:
            self.connection.forget_presses()
        clock = FrameClock(self.game_id, self._lateness)
        while not self._stopped.is_set() and self._recorder.episode.end is None:
            connection = self.connection
            if connection is None or not connection.is_open:
                return
            if connection.stalled_for_s > self._rules.stalled_after_s:
                self._is_stalled = True
                return
            await self._tick(connection)
            await clock.wait(self._conditions.speed_percent)

    async def _tick(self, connection: Connection) -> None:
        episode = self._recorder.episode
        n_hits = len(episode.hits)
        self._tape.note(episode)
        self._recorder.advance(action_for(connection.take_keys()))
        for hit in hits_after(self._behaviour, episode, n_hits):
            await connection.tell(hit)
        if not await self._show():
            self._conditions.dropped.append(episode.frame)

    async def _show(self) -> bool:
        """Send the screen; returns whether the page was there and not too far behind."""
        if self.connection is None:
            return False
        return await self.connection.show(Scene.of(self._recorder.episode))

    async def _tell_countdown(self, seconds: int) -> None:
        if self.connection is not None:
            await self.connection.tell(Countdown(seconds=seconds))

    def _stand_still(self) -> None:
        """Wait for the player from now on, unless the game is over."""
        if self.phase is not Phase.ENDED:
            self.phase = Phase.WAITING
        self.still_since = asyncio.get_running_loop().time()

    async def _halt(self) -> None:
        """Stop counting or playing and wait until the frame at hand is through."""
        task = self._task
        if task is None or task is asyncio.current_task() or self.phase is Phase.ENDED:
            return
        self._stopped.set()
        await asyncio.wait([task])
        self._stopped.clear()

    def _end(self) -> None:
        if self.phase is Phase.ENDED:
            return
        self.phase = Phase.ENDED
        self._task = asyncio.create_task(self._run_finish(), name=f"end of {self.game_id}")

    async def _run_finish(self) -> None:
        await self._finish(self)


async def _dismiss(connection: Connection) -> None:
    await connection.tell(TakenOver())
    await connection.close(Close.TAKEN_OVER, "The game goes on in another tab.")
