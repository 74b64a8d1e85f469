"""A game that this process owns: its phases, its page and the player's commands."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable, Coroutine
from dataclasses import dataclass
from enum import Enum, auto

from server.play.consoles import ConsolePool
from server.play.lateness import Lateness
from server.play.rules import PlayRules
from server.play.session.activity import Activity
from server.play.session.clock import FrameClock, JumpDetector, ProcessSuspended, is_set_within
from server.play.session.live_game import LiveGame
from server.play.session.rewind import play_backwards
from server.play.wire.byte_budget import TokenBucket
from server.play.wire.connection import Connection
from server.play.wire.protocol import (
    Close,
    Command,
    Countdown,
    Paused,
    ServerMessage,
    TakenOver,
)
from server.play.wire.scene import Scene
from tril.recording import Recorder

WHY_PAUSED = "You paused the game."
WHY_STALLED = (
    "The page stopped drawing, so the game waits. It goes on by itself when the page draws again; "
    "if this happens often, the connection or the machine is too slow."
)
WHY_NO_REWIND = (
    "You rewound this game very often in a short time, and every time a recording is kept. Wait a "
    "few seconds before the next one."
)
WHY_TAKEN_OVER = "The game goes on in another tab."


class Phase(Enum):
    """The state of a session: WAITING for the player, COUNTING down, and so on."""

    WAITING = auto()
    COUNTING = auto()
    PLAYING = auto()
    REWINDING = auto()
    ENDED = auto()


@dataclass(frozen=True)
class RewoundGame:
    """A game up to the frame at which it resumes, and the recording of it as it was."""

    recorder: Recorder
    recording_id: int


@dataclass(frozen=True)
class SessionResources:
    """What the sessions of a process share."""

    consoles: ConsolePool
    rules: PlayRules
    lateness: Lateness


@dataclass(frozen=True)
class SessionEvents:
    """What a session reports to.

    Attributes:
        on_rewind: Called with a frame to resume from: keeps the game as it was and rebuilds it up
            to that frame; returns None if that was not possible.
        on_end: Called once when the game is over, played to its end or stopped.
        on_error: Called after an unexpected error.
    """

    on_rewind: Callable[[PlaySession, int], Awaitable[RewoundGame | None]]
    on_end: Callable[[PlaySession], Coroutine[None, None, None]]
    on_error: Callable[[PlaySession], Awaitable[None]]


class PlaySession:
    """A game that this process owns.

    All methods run in the event loop and never wait for the database.

    Attributes:
        game: The game.
        connection: The page that shows it, if any.
        phase: The current phase.
        left_at: When its page left; this and the following by the event loop's clock.
        waiting_since: When the current phase WAITING began.
        save_tried_at: When it was last saved or tried to be.
    """

    def __init__(self, game: LiveGame, resources: SessionResources, events: SessionEvents) -> None:
        self.game = game
        self.connection: Connection | None = None
        self.phase = Phase.WAITING
        self._resources = resources
        self._events = events
        self._activity = Activity(f"game {self.game_id}", lambda: events.on_error(self))
        self._rewind_released = asyncio.Event()
        self._is_stalled = False
        now = asyncio.get_running_loop().time()
        rules = resources.rules
        self._rewinds = TokenBucket(1 / rules.rewind_every_s, rules.rewinds_at_once, now)
        self.left_at = self.waiting_since = self.save_tried_at = now

    @property
    def game_id(self) -> str:
        """The game's id."""
        return self.game.info.game_id

    @property
    def is_stopping(self) -> bool:
        """Whether somebody waits for the game to stand still."""
        return self._activity.stop_requested.is_set()

    @property
    def needs_saving(self) -> bool:
        """Whether there are unsaved frames that a rewind is not about to commit."""
        return self.phase is not Phase.REWINDING and self.game.is_dirty

    async def attach(self, connection: Connection) -> None:
        """Show the game, which stands still, on a page; the previous page is told and closed."""
        self._is_stalled = False
        self.waiting_since = asyncio.get_running_loop().time()
        before, self.connection = self.connection, connection
        if before is not None:
            await before.close(Close.TAKEN_OVER, WHY_TAKEN_OVER, TakenOver())
        await connection.send(self.game.greeting())
        await self._show()
        if self.game.episode.end is not None:
            self._end()

    async def detach(self, connection: Connection) -> None:
        """Pause because a page has left, unless another one has taken over."""
        if self.connection is not connection:
            return
        self.connection = None
        self.left_at = asyncio.get_running_loop().time()
        await self.halt()

    async def close(
        self, code: Close, reason: str, last_message: ServerMessage | None = None
    ) -> None:
        """End the session in this process and close its page's connection."""
        await self.halt()
        self.phase = Phase.ENDED
        connection, self.connection = self.connection, None
        if connection is not None:
            await connection.close(code, reason, last_message)

    async def shut_down(self) -> None:
        """Stop the clock because the process stops; an end under way is completed."""
        await self.halt()
        if self.phase is Phase.ENDED:
            await self._activity.join()

    async def send(self, message: ServerMessage) -> None:
        """Send a message to the page, if there is one."""
        if self.connection is not None:
            await self.connection.send(message)

    async def pause(self, why: str) -> None:
        """Pause the game and tell the player why."""
        if self.phase is Phase.ENDED:
            return
        await self.halt()
        self._is_stalled = False
        await self.send(Paused(why=why))

    async def acknowledge(self) -> None:
        """Handle an acknowledgement: show a frame that was dropped, or resume a stalled game."""
        connection = self.connection
        if connection is None:
            return
        for frame, latency_ms in connection.take_latencies():
            self.game.conditions.note_press(frame, latency_ms)
        if self.phase in {Phase.PLAYING, Phase.REWINDING}:
            return
        if connection.shown_frame != self.game.episode.frame:
            await self._show()
        elif self._is_stalled and not connection.n_unacknowledged:
            self._begin()

    def set_speed(self, percent: int) -> None:
        """Change the game's speed."""
        self.game.conditions.set_speed(self.game.episode.frame, percent)

    async def handle(self, command: Command) -> None:
        """Execute a player's command; one that makes no sense in this phase is ignored."""
        if self.phase is Phase.ENDED:
            return
        match command.type:
            case "ready" | "go_on":
                self._begin()
            case "pause":
                if self.phase is Phase.PLAYING:
                    self.game.conditions.note_pause(self.game.episode.frame)
                await self.pause(WHY_PAUSED)
            case "step":
                await self._step()
            case "rewind":
                await self._begin_rewind()
            case "release":
                self._rewind_released.set()
            case "stop":
                await self.halt()
                self._end()

    @property
    def _is_idle(self) -> bool:
        return self.phase is Phase.WAITING and not self._activity.is_running

    def _begin(self) -> None:
        """Count down and play, unless the game runs already."""
        if self._is_idle:
            self._is_stalled = False
            self._activity.start(self._count_down_and_play())

    async def _step(self) -> None:
        """Execute one frame of a paused game."""
        if self._is_idle and self.connection is not None:
            self._is_stalled = False
            self.game.conditions.single_steps.append(self.game.episode.frame + 1)
            # As the session's task, so that stopping the game waits until the frame is complete.
            self._activity.start(self._play_one_frame(self.connection))
            await self._activity.join()

    async def _play_one_frame(self, connection: Connection) -> None:
        try:
            await self._tick(connection)
        finally:
            self._wait_for_player()
        if self.game.episode.end is not None:
            self._end()

    async def _begin_rewind(self) -> None:
        await self.halt()
        if self._is_idle and self.connection is not None:
            if not self._rewinds.take(1, asyncio.get_running_loop().time()):
                await self.pause(WHY_NO_REWIND)
                return
            self._is_stalled = False
            self._rewind_released.clear()
            self._activity.start(self._rewind(self.connection))

    async def _rewind(self, connection: Connection) -> None:
        """Play backwards until the player releases the button, and resume there."""
        released, stop = self._rewind_released, self._activity.stop_requested
        why = ""
        try:
            self.phase = Phase.REWINDING
            frame = await play_backwards(
                self.game.checkpoints,
                self.game.recorder.recording(),
                self._resources.consoles,
                connection.show,
                lambda: stop.is_set() or released.is_set() or not connection.is_open,
            )
            if not released.is_set() or stop.is_set():
                return
            if frame < self.game.episode.frame:
                rewound = await self._events.on_rewind(self, frame)
                if rewound is None:
                    return
                message, console = self.game.rewind(rewound.recorder, rewound.recording_id)
                self._resources.consoles.give_back(console)
                await connection.send(message)
        except ProcessSuspended as error:
            why = str(error)
        finally:
            self._wait_for_player()
        if why:
            await self._show()
            await self.send(Paused(why=why))
        elif not stop.is_set():
            self._begin()

    async def _count_down_and_play(self) -> None:
        rules, stop = self._resources.rules, self._activity.stop_requested
        why = ""
        try:
            self.phase = Phase.COUNTING
            jumps = JumpDetector()
            for seconds in range(rules.countdown, 0, -1):
                await self.send(Countdown(seconds=seconds))
                if await is_set_within(stop, rules.countdown_second_s):
                    return
                jumps.check(rules.countdown_second_s)
            await self.send(Countdown(seconds=0))
            self.phase = Phase.PLAYING
            with self._resources.consoles.loading_suspended():
                why = await self._play()
        except ProcessSuspended as error:
            why = str(error)
        finally:
            self._wait_for_player()
        if self.game.episode.end is not None:
            self._end()
        elif why:
            await self.send(Paused(why=why))

    async def _play(self) -> str:
        """Execute frames; returns why the game was paused, if its player has to be told.

        Raises:
            ProcessSuspended: Time jumped.
        """
        if self.connection is not None:
            self.connection.discard_taps()
        frame_rate_hz = self.game.episode.game.clock.frame_rate_hz
        clock = FrameClock(self.game_id, frame_rate_hz, self._resources.lateness)
        while not self.is_stopping and self.game.episode.end is None:
            connection = self.connection
            if connection is None or not connection.is_open:
                break
            if connection.stalled_for_s > self._resources.rules.stalled_after_s:
                self._is_stalled = True
                return WHY_STALLED
            if connection.holds_button or not self.game.episode.game.controls.waits:
                await self._tick(connection)
            await clock.wait(self.game.conditions.speed_percent)
        return ""

    async def _tick(self, connection: Connection) -> None:
        """Execute and show one frame."""
        hits, scene = await self.game.advance(connection.take_buttons())
        for hit in hits:
            await connection.send(hit)
        if self.connection is None or not await self.connection.show(scene):
            self.game.conditions.dropped.append(scene.frame)

    async def _show(self) -> bool:
        """Send the screen; returns whether there is a page that is not too far behind."""
        if self.connection is None:
            return False
        return await self.connection.show(Scene.of(self.game.episode))

    def _wait_for_player(self) -> None:
        """Enter the phase WAITING, unless the game is over."""
        if self.phase is not Phase.ENDED:
            self.phase = Phase.WAITING
        self.waiting_since = asyncio.get_running_loop().time()
        self._activity.finish()

    async def halt(self) -> None:
        """Stop counting, playing or rewinding, after the current frame."""
        if self.phase is not Phase.ENDED:
            await self._activity.stop()

    def _end(self) -> None:
        if self.phase is not Phase.ENDED:
            self.phase = Phase.ENDED
            self._activity.start(self._events.on_end(self))
