"""Games that policies play side by side, in step with each other, before one page."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Awaitable, Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from server.play.conditions import FULL_SPEED_PERCENT
from server.play.session.activity import Activity
from server.play.session.clock import FrameClock, JumpDetector
from server.play.session.session import WHY_STALLED, Phase, SessionResources
from server.play.watch.attention_feed import AttentionFeed
from server.play.watch.lane import Lane
from server.play.watch.messages import (
    Decision,
    Finished,
    LaneReward,
    Playing,
    ShowAttention,
    TakeOver,
    Waiting,
    WatchCommand,
    WatchPaused,
    watch_hello,
)
from server.play.watch.policy_client import PolicyClient
from server.play.watch.watch_socket import WatchSocket
from tril.errors import TrilError
from tril.play.observation import Observations

_LOG = logging.getLogger(__name__)

REWARD_EVERY_S = 0.2
"""Nobody reads the figure faster, and a reward model takes longer than a policy."""

PATIENCE_S = 0.5
"""How long the games wait for decisions before the page says so."""


@dataclass(frozen=True)
class WatchEvents:
    """What a session reports to.

    Attributes:
        on_take_over: Called with a lane whose game a person goes on with; raises a TrilError if
            that is not possible.
        on_error: Called after an unexpected error.
    """

    on_take_over: Callable[[WatchSession, Lane], Awaitable[None]]
    on_error: Callable[[WatchSession], Awaitable[None]]


class WatchSession:
    """Games that policies play side by side, at one clock.

    The action of a step is asked for when the observation of the step before is complete, and the
    next frame waits for it; see docs/decisions/19-inference.md. All methods run in the event loop.

    Args:
        lanes: The games, all at the same frame.
        start_number: Evaluation start of the games, if they have one.
        socket: The page's socket.
        connect: Connects to the run's networks. Actions, rewards and attention maps have a
            connection each, so that no action waits for the others.
        resources: Resources shared by all games of the process, frames' lateness among them.
        events: Receiver of the session's events.

    Attributes:
        phase: The current phase: WAITING while paused, PLAYING or ENDED.
        waiting_since: When the current phase began, by the event loop's clock.
        speed_percent: Speed in percent of 60 frames a second.
    """

    def __init__(
        self,
        lanes: Sequence[Lane],
        start_number: int | None,
        socket: WatchSocket,
        connect: Callable[[], PolicyClient],
        resources: SessionResources,
        events: WatchEvents,
    ) -> None:
        self.lanes = tuple(lanes)
        self.socket = socket
        self.phase = Phase.WAITING
        self.speed_percent = FULL_SPEED_PERCENT
        self.waiting_since = asyncio.get_running_loop().time()
        self._start_number = start_number
        self._actors = connect()
        self._critic: PolicyClient | None = connect()
        self._attention = AttentionFeed(self.lanes, socket, connect())
        self._resources = resources
        self._events = events
        self._activity = Activity("a watched game", lambda: events.on_error(self))
        self._asking: asyncio.Task[None] | None = None
        self._rewarding: asyncio.Task[None] | None = None
        self._rewarded_at = -REWARD_EVERY_S

    async def greet(self) -> None:
        """Show the games at their beginning."""
        first = self.lanes[0].game.episode
        actors = [lane.game.actor for lane in self.lanes]
        await self.socket.send_message(
            watch_hello(first, actors, self._start_number, self.speed_percent)
        )
        for lane in self.lanes:
            await lane.show()

    async def handle(self, message: WatchCommand | TakeOver | ShowAttention) -> None:
        """Execute a command; one that makes no sense in this phase is ignored."""
        if isinstance(message, ShowAttention):
            await self._attention.show(message.network)
            return
        if self.phase is Phase.ENDED or not self._in_play:
            return
        if isinstance(message, TakeOver):
            await self._take_over(self.lanes[message.lane])
        elif message.type == "pause":
            if self.phase is Phase.PLAYING:
                await self._activity.stop()
                await self.socket.send_message(WatchPaused(why=""))
        elif self.phase is Phase.WAITING and not self._activity.is_running:
            # Not waited for: the page may pause games that wait for a decision.
            self._activity.start(self._play(one_step=message.type == "step"))

    async def close(self) -> None:
        """End the games: nothing of them is left."""
        await self._activity.stop()
        self.phase = Phase.ENDED
        tasks = [task for task in (self._asking, self._rewarding) if task is not None]
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)
        await self._attention.close()
        self._actors.close()
        if self._critic is not None:
            self._critic.close()

    @property
    def is_playing(self) -> bool:
        """Whether frames follow each other."""
        return self.phase is Phase.PLAYING

    @property
    def _in_play(self) -> list[Lane]:
        return [lane for lane in self.lanes if not lane.game.is_over]

    async def _take_over(self, lane: Lane) -> None:
        if lane.game.is_over:
            return
        await self._activity.stop()
        # So that games that were paused for long are not closed meanwhile.
        self.waiting_since = asyncio.get_running_loop().time()
        try:
            await self._events.on_take_over(self, lane)
        except TrilError as error:
            await self.socket.send_message(WatchPaused(why=str(error)))

    async def _play(self, one_step: bool) -> None:
        self.phase = Phase.PLAYING
        why = ""
        try:
            if not one_step:
                await self.socket.send_message(Playing())
            with self._resources.consoles.loading_suspended():
                why = await self._advance(one_step)
        except TrilError as error:
            why = str(error)
        finally:
            self.phase = Phase.WAITING
            self.waiting_since = asyncio.get_running_loop().time()
            is_stopping = self._activity.stop_requested.is_set()
            self._activity.finish()
        if not self._in_play:
            await self.socket.send_message(Finished())
        elif not is_stopping:
            await self.socket.send_message(WatchPaused(why=why))

    async def _advance(self, one_step: bool) -> str:
        """Execute frames until the games are over, stopped or, for one step, at its end.

        Returns:
            Why they stopped, if the person has to be told.

        Raises:
            TrilError: There are no decisions to go on with.
        """
        await self._await_decisions()
        frame_rate_hz = self.lanes[0].game.episode.game.clock.frame_rate_hz
        clock = FrameClock("watched", frame_rate_hz, self._resources.lateness)
        while not self._activity.stop_requested.is_set():
            if not self.socket.is_open:
                break
            stalled_s = max(lane.connection.stalled_for_s for lane in self._in_play)
            if stalled_s > self._resources.rules.stalled_after_s:
                return WHY_STALLED
            await self._tick()
            if not self._in_play or (one_step and self._in_play[0].game.at_boundary):
                break
            await clock.wait(self.speed_percent, self._await_decisions)
        return ""

    async def _tick(self) -> None:
        """Execute and show one frame of each game that is not over."""
        for lane in self._in_play:
            hits, scene = await lane.advance()
            for hit in hits:
                await self.socket.send_message(hit)
            await lane.connection.show(scene)
            if lane.game.is_over:
                await self.socket.send_message(lane.ended())
            # Other games of the process may have frames that are due.
            await asyncio.sleep(0)
        if any(lane.game.needs_action for lane in self.lanes):
            self._ask()

    async def _await_decisions(self) -> None:
        """Wait for the decisions of the next frame's actions, or for the games to stop.

        Raises:
            TrilError: No decision is possible, or time jumped meanwhile.
        """
        if not any(lane.game.needs_action for lane in self.lanes):
            return
        asking = self._asking
        if asking is None or asking.done():
            asking = self._ask()
        stopped = asyncio.create_task(self._activity.stop_requested.wait())
        tasks: set[asyncio.Task[Any]] = {asking, stopped}
        jumps = JumpDetector()
        is_said = False
        try:
            while True:
                done, _ = await asyncio.wait(
                    tasks, timeout=PATIENCE_S, return_when="FIRST_COMPLETED"
                )
                jumps.check(PATIENCE_S)
                if done:
                    break
                if not is_said:
                    await self.socket.send_message(Waiting())
                    is_said = True
            if is_said:
                await self.socket.send_message(Playing())
        finally:
            stopped.cancel()
        if asking.done():
            asking.result()

    def _ask(self) -> asyncio.Task[None]:
        """Ask for the actions of the next step, all games in one request."""
        self._asking = asyncio.create_task(self._decide(), name="decisions")
        # Whoever waits for it raises the error; a page that has left does not wait.
        self._asking.add_done_callback(lambda task: task.cancelled() or task.exception())
        return self._asking

    async def _decide(self) -> None:
        lanes = [lane for lane in self.lanes if lane.game.needs_action]
        observations = np.stack([lane.game.observation for lane in lanes])
        rows = await self._actors.act([lane.game.actor.policy for lane in lanes], observations)
        decisions = [
            Decision(
                lane=lane.number,
                frame=lane.game.episode.frame,
                action=lane.game.decide(row),
                probabilities=[round(float(share), 4) for share in row],
            )
            for lane, row in zip(lanes, rows, strict=True)
        ]
        # Now, since the processor is free until the step is complete.
        self._ask_for_rewards(lanes, observations)
        for decision in decisions:
            await self.socket.send_message(decision)

    def _ask_for_rewards(self, lanes: Sequence[Lane], observations: Observations) -> None:
        """Ask for R of the games' states, unless the last answer is new or still to come."""
        now = asyncio.get_running_loop().time()
        is_asking = self._rewarding is not None and not self._rewarding.done()
        if self._critic is None or is_asking or now - self._rewarded_at < REWARD_EVERY_S:
            return
        self._rewarded_at = now
        frames = [lane.game.episode.frame for lane in lanes]
        self._rewarding = asyncio.create_task(
            self._show_rewards(self._critic, lanes, frames, observations), name="rewards"
        )

    async def _show_rewards(
        self,
        critic: PolicyClient,
        lanes: Sequence[Lane],
        frames: Sequence[int],
        observations: Observations,
    ) -> None:
        try:
            zero_level, unit_level = await critic.scale()
            judged = await critic.judge(observations)
        except TrilError as error:
            # The figure is left out; whether the games can go on is for their actions to say.
            _LOG.info("No rewards are shown: %s", error)
            self._critic = None
            critic.close()
            return
        levels = (judged.rewards - zero_level) / (unit_level - zero_level)
        deviations = judged.deviations
        for index, (lane, frame) in enumerate(zip(lanes, frames, strict=True)):
            await self.socket.send_message(
                LaneReward(
                    lane=lane.number,
                    frame=frame,
                    level=float(levels[index]),
                    deviation=None
                    if deviations is None
                    else float(deviations[index]) / abs(unit_level - zero_level),
                )
            )
