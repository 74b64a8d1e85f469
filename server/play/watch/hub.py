"""The watched games of this process: opened, taken over, closed."""

from __future__ import annotations

import asyncio
from collections.abc import Collection
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np
from sqlalchemy.orm import Session

from server.play.background import PeriodicTask
from server.play.conditions import BegunBy, PlayConditions
from server.play.consoles import ConsolePool
from server.play.hub import PlayHub
from server.play.lateness import Lateness
from server.play.limits import GameLimits, TooManyGames
from server.play.rules import PlayRules
from server.play.saving.committer import Committer
from server.play.session.session import Phase, SessionResources
from server.play.watch.lane import Lane
from server.play.watch.messages import Actor, Taken, WatchRequest
from server.play.watch.policy_client import PolicyClient
from server.play.watch.policy_game import PolicyGame
from server.play.watch.session import WatchEvents, WatchSession
from server.play.watch.watch_socket import WatchSocket
from server.play.wire.protocol import Close
from tril.errors import NotFound
from tril.games import game_of
from tril.games.base import Console, Game, Opening, Start, draw_start, evaluation_beginning
from tril.games.behaviours import Behaviour
from tril.inference import Endpoint
from tril.recipes import recipe_from_dict
from tril.recording import Recording, Verified, verify
from tril.store import behaviours, games, processes
from tril.store.database import Database
from tril.store.models import RunRow, RunStatus
from tril.store.training import artifacts, runs

TRY_AGAIN_S = 0.5
"""Seconds after which a page that waits for slots looks for them again, at the latest."""

WHY_IDLE = "The game was paused for long."
WHY_FAILED = "An error stopped the game."


@dataclass(frozen=True)
class WatchPlan:
    """What is played before a page.

    Attributes:
        player_id: The person who watches, and plays on.
        run_id: The run whose policies play.
        behaviour_id: Behaviour that the policies were taught.
        behaviour: Domain value of the behaviour, to score hits.
        beginning: Where the games begin.
        game: Game to play.
        end_rule: Name of the rule by which a loss ends them.
        players: Actors, each with the seed of its sampled and repeated actions.
    """

    player_id: int
    run_id: str
    behaviour_id: int
    behaviour: Behaviour
    beginning: Start | Opening
    game: Game
    end_rule: str
    players: tuple[tuple[Actor, int], ...]


class WatchHub:
    """The watched games of this process. They leave nothing behind unless they are taken over.

    Args:
        database: Has the runs; receives games that are taken over.
        consoles: The pool to take consoles from.
        games: The games that are played in this process.
        inference: Where the inference process answers.
        rules: Timing and the limit of games in a process.
        limits: Limits on the number of open games.

    Attributes:
        lateness: Lateness of frames since the process started, waits for decisions included.
    """

    def __init__(
        self,
        database: Database,
        consoles: ConsolePool,
        games: PlayHub,
        inference: Endpoint,
        rules: PlayRules,
        limits: GameLimits,
    ) -> None:
        self.lateness = Lateness()
        self._consoles = consoles
        self._games = games
        self._inference = inference
        self._rules = rules
        self._limits = limits
        self._committer = Committer(database)
        self._resources = SessionResources(consoles, rules, self.lateness)
        self._events = WatchEvents(self._on_take_over, self._on_error)
        self._sessions: dict[WatchSession, WatchPlan] = {}
        # Set when slots are released, and then replaced.
        self._left = asyncio.Event()
        self._tasks = (PeriodicTask("watched", self._close_idle, rules.sweep_every_s),)

    @property
    def background_tasks(self) -> Collection[PeriodicTask]:
        """The task that closes games that stay paused."""
        return self._tasks

    def start(self) -> None:
        """Start closing games that stay paused."""
        for task in self._tasks:
            task.start()

    async def stop(self) -> None:
        """Close all games."""
        await asyncio.gather(*(task.stop() for task in self._tasks))
        for session in list(self._sessions):
            await self.close(session)
        self._committer.close()

    async def open(
        self, request: WatchRequest, socket: WatchSocket, player_id: int
    ) -> WatchSession:
        """Open games for a person's page.

        Raises:
            NotFound: There is no such run, or it has no such policy; says why.
            Unavailable: Too many games are open.
        """
        # Before slots are reserved, so that requests for unknown runs keep nobody from playing.
        plan = await self._committer.run(lambda session: _plan(session, request, player_id))
        await self._reserve(len(plan.players), player_id)
        try:
            played = await asyncio.to_thread(self._begin, plan)
        except BaseException:
            self._cancel_reservation(len(plan.players), player_id)
            raise
        session = WatchSession(
            [Lane(n, game, plan.behaviour, socket) for n, game in enumerate(played)],
            request.start_number,
            socket,
            lambda: PolicyClient(self._inference, plan.run_id),
            self._resources,
            self._events,
        )
        self._sessions[session] = plan
        return session

    async def close(self, session: WatchSession) -> None:
        """End a page's games."""
        plan = self._sessions.pop(session, None)
        if plan is None:
            return
        # At once: a page that watches other games opens them while these come to a stop.
        self._cancel_reservation(len(plan.players), plan.player_id)
        await session.close()
        for lane in session.lanes:
            self._consoles.give_back(lane.game.episode.console)

    async def _reserve(self, n_games: int, player_id: int) -> None:
        """Reserve slots for games, if need be after the player's other pages release theirs.

        A page that moves on to other games opens them while it closes the old ones.

        Raises:
            TooManyGames: No slot is free.
        """
        clock = asyncio.get_running_loop().time
        deadline = clock() + self._rules.leaving_s
        while True:
            page_left = self._left
            try:
                return await self._try_reserve(n_games, player_id)
            except TooManyGames:
                may_leave = page_left.is_set() or self._limits.watched.of_players[player_id] > 0
                if clock() >= deadline or not may_leave:
                    raise
            # Other games end without a word to this hub.
            with suppress(TimeoutError):
                await asyncio.wait_for(page_left.wait(), TRY_AGAIN_S)

    async def _try_reserve(self, n_games: int, player_id: int) -> None:
        if self._games.n_games + self._limits.watched.n_open + n_games > self._rules.max_games:
            raise TooManyGames(
                "This process plays as many games as it can. Games are short: try again in a "
                "minute, or watch fewer side by side."
            )
        watched = self._limits.watched
        watched.of_players[player_id] += n_games

        def check(session: Session) -> None:
            # The games have their slots already.
            self._limits.check(session, player_id, n_new=0)
            # At once, so that no process gives them away before the next heartbeat.
            processes.report_details(session, watched.process, watched.details())

        try:
            await self._committer.run(check)
        except BaseException:
            self._release(n_games, player_id)
            raise

    def _release(self, n_games: int, player_id: int) -> None:
        of_players = self._limits.watched.of_players
        of_players[player_id] -= n_games
        if not of_players[player_id]:
            del of_players[player_id]

    def _cancel_reservation(self, n_games: int, player_id: int) -> None:
        self._release(n_games, player_id)
        self._left.set()
        self._left = asyncio.Event()

    def _begin(self, plan: WatchPlan) -> list[PolicyGame]:
        consoles: list[Console] = []
        try:
            for _ in plan.players:
                consoles.append(self._consoles.take(plan.game))
            return [
                PolicyGame(console, actor, plan.beginning, plan.end_rule, seed)
                for console, (actor, seed) in zip(consoles, plan.players, strict=True)
            ]
        except BaseException:
            for console in consoles:
                self._consoles.give_back(console)
            raise

    async def _on_take_over(self, session: WatchSession, lane: Lane) -> None:
        plan = self._sessions.get(session)
        if plan is None:
            return
        # A person's game ends by the game's default rule, whatever the run's recipe says.
        recording = replace(lane.game.recording(), end_rule=plan.game.end_rule)
        begun = await asyncio.to_thread(self._verify, recording)
        actor = lane.game.actor
        conditions = PlayConditions(
            begun_by=BegunBy(
                run_id=plan.run_id,
                policy=actor.policy,
                action_selection=actor.action_selection,
                frames=recording.n_frames,
            )
            if recording.n_frames
            else None
        ).to_conditions()

        def take_over(transaction: Session) -> str:
            # The page may have left meanwhile, and released its slots.
            n_counted = len(session.lanes) if session in self._sessions else 0
            self._limits.check(transaction, plan.player_id, n_counted=n_counted)
            return games.create_taken_over(
                transaction, plan.behaviour_id, begun, plan.player_id, conditions
            ).id

        game_id = await self._committer.run(take_over)
        message = Taken(lane=lane.number, game_id=game_id, behaviour_id=plan.behaviour_id)
        await session.socket.close(Close.GAME_OVER, "You play on.", message)
        await self.close(session)

    def _verify(self, recording: Recording) -> Verified:
        with self._consoles.lent(recording.game) as console:
            return verify(recording, console=console)

    async def _on_error(self, session: WatchSession) -> None:
        await session.socket.close(Close.INTERNAL_ERROR, WHY_FAILED)
        await self.close(session)

    async def _close_idle(self) -> None:
        now = asyncio.get_running_loop().time()
        idle_s = self._rules.idle_after.total_seconds()
        for session in list(self._sessions):
            if session.phase is Phase.WAITING and now - session.waiting_since > idle_s:
                await session.socket.close(Close.GAME_OVER, WHY_IDLE)
                await self.close(session)


def _plan(session: Session, request: WatchRequest, player_id: int) -> WatchPlan:
    run = runs.get(session, request.run_id)
    for actor in request.actors:
        _check_trained(session, run, actor.policy)
    recipe = recipe_from_dict(run.recipe)
    behaviour = behaviours.as_behaviour(behaviours.get(session, run.behaviour_id))
    game = game_of(behaviour)
    return WatchPlan(
        player_id,
        run.id,
        run.behaviour_id,
        behaviour,
        _beginning_of(game, request, recipe.evaluation.openings),
        game,
        game.known_end_rule(recipe.ending),
        tuple(zip(request.actors, _seeds(request, run.training_seed), strict=True)),
    )


def _check_trained(session: Session, run: RunRow, policy: str) -> None:
    """Check that a run has a policy.

    Raises:
        NotFound: It has not; says why.
    """
    try:
        artifacts.of_kind(session, run.id, policy)
    except NotFound:
        raise NotFound(
            f"This training ended before its {policy} was trained, so there is nothing to watch."
            if RunStatus(run.status).is_over
            else f"This training has no {policy} yet. It can be watched as soon as it is trained."
        ) from None


def _beginning_of(game: Game, request: WatchRequest, openings: bool) -> Start | Opening:
    if request.start_number is not None:
        return evaluation_beginning(game.starts, request.start_number, openings)
    rng = np.random.default_rng(request.draw)
    return game.starts.draw_opening(draw_start(game.starts, rng), rng)


def _seeds(request: WatchRequest, training_seed: int) -> list[int]:
    """Return a seed for each game; those of an evaluation's games at the first take.

    Equal players side by side draw different actions.
    """
    seeds = []
    for index, actor in enumerate(request.actors):
        n_before = request.actors[:index].count(actor)
        drawn = np.random.SeedSequence((training_seed, request.take, n_before)).generate_state(1)
        is_evaluation = request.take == 0 and n_before == 0
        seeds.append(training_seed if is_evaluation else int(drawn[0]))
    return seeds
