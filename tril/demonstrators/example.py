"""Make demonstrations: games of the scripted player that fulfil their plans."""

from __future__ import annotations

import atexit
import logging
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import cache
from multiprocessing import get_context
from typing import Any

import numpy as np

from tril.demonstrators.error_model import PERFECT, ErrorModel
from tril.demonstrators.judging import PlannedGame
from tril.demonstrators.kinds import SCRIPTED, ExampleKind
from tril.demonstrators.space_invaders.human_like import HumanLikePlayer
from tril.demonstrators.space_invaders.plans import (
    DemonstrationPlan,
    GameOutcome,
    best_effort_violation,
    draw_hits,
    example_plans,
    plan_violation,
    rule_violation,
    tolerance_violation,
)
from tril.demonstrators.space_invaders.player import (
    PlayStyle,
    ScriptedPlayer,
    draw_brisk_style,
    draw_style,
)
from tril.errors import Unavailable
from tril.games.atari.starts import TRAINING_IDLE_FRAMES, AtariStart
from tril.games.base import Console, Start
from tril.games.behaviours import Behaviour
from tril.games.space_invaders import SPACE_INVADERS
from tril.play.episode import Episode
from tril.recording import Recorder, Recording, Replay

_LOG = logging.getLogger(__name__)

N_PERFECT = 12
"""Perfect demonstrations of an example, for the clone."""
MAX_ATTEMPTS = 12
"""Attempts at a plan; about 4 of 5 succeed for the hardest."""
MAX_HUMAN_ATTEMPTS = 300
"""Attempts with player errors. They take a quarter of the time, without look-ahead; about 1 in 10
perfect games of column 6 succeeds."""


class DemonstrationFailed(Unavailable):
    """No game of the scripted player fulfilled the plan."""


@dataclass(frozen=True)
class Demonstration:
    """A game of the scripted player that fulfilled its plan, within tolerance if human-like.

    Attributes:
        recording: The game.
        replay: The outcome of a replay.
        plan: Demonstration to make.
        perfect: Whether the game is for cloning and not ranked.
        error_model: Player errors.
    """

    recording: Recording
    replay: Replay
    plan: DemonstrationPlan
    perfect: bool = False
    error_model: ErrorModel = PERFECT

    @property
    def shown(self) -> PlannedGame:
        """Its outcome, for ranking."""
        hits = tuple(item.cell for item in self.replay.taken)
        return PlannedGame(self.plan.number, hits, self.replay.end)

    @property
    def notes(self) -> str:
        """The plan's description, marked as intended where the game may deviate from it."""
        is_intention = self.error_model != PERFECT and not self.perfect
        return f"Meant as: {self.plan.description}" if is_intention else self.plan.description

    @property
    def conditions(self) -> dict[str, Any]:
        """The error model, for a recording's conditions; empty if flawless."""
        return {} if self.error_model == PERFECT else {"manner": self.error_model.to_dict()}


@dataclass(frozen=True)
class DemonstrationTask:
    """A demonstration to make. Tasks are independent of each other and of their order.

    Attributes:
        plan: Plan of the game.
        perfect: Whether the game is for cloning.
        idle_frames: The starts to try, in turn.
        seed: Seed of the player's random choices.
        error_model: Player errors.
        best_effort: Whether a good attempt is enough where it is for cloning.
    """

    plan: DemonstrationPlan
    perfect: bool
    idle_frames: tuple[int, ...]
    seed: int
    error_model: ErrorModel = PERFECT
    best_effort: bool = False


def demonstrate(
    plan: DemonstrationPlan,
    start: Start,
    rng: np.random.Generator,
    console: Console | None = None,
    style: PlayStyle | None = None,
    error_model: ErrorModel = PERFECT,
    perfect: bool = False,
    best_effort: bool = False,
) -> Demonstration:
    """Play one game that shows a plan.

    A flawless or perfect game has to fulfil the plan exactly and to be survived. Other human-like
    games have to fulfil it within tolerance.

    Args:
        plan: Plan of the game.
        start: Start of the game.
        rng: Source of the player's random choices.
        console: The console to play on; None loads one.
        style: Playing style; None draws one.
        error_model: Player errors.
        perfect: Whether the game is for cloning.
        best_effort: Whether a good attempt is enough for that.

    Raises:
        DemonstrationFailed: The game doesn't show the plan.
    """
    recorder = Recorder(Episode(console or SPACE_INVADERS.make_console(), start))
    hits = draw_hits(plan, rng)
    style = style or draw_style(rng)
    if error_model == PERFECT:
        ScriptedPlayer(recorder, hits, style, rng).play()
    else:
        HumanLikePlayer(recorder, hits, style, error_model, rng).play()
    demonstration = Demonstration(
        recorder.recording(), recorder.replay(), plan, perfect, error_model
    )
    if reason := _refusal(demonstration, best_effort):
        raise DemonstrationFailed(reason)
    return demonstration


def _refusal(demonstration: Demonstration, best_effort: bool) -> str | None:
    """Return why a game doesn't demonstrate its plan, None if it does."""
    hits, end = demonstration.shown.hits, demonstration.replay.end
    if demonstration.perfect and best_effort:
        return best_effort_violation(demonstration.plan, hits)
    if demonstration.error_model != PERFECT and not demonstration.perfect:
        return tolerance_violation(demonstration.plan, hits)
    if demonstration.error_model != PERFECT and end is None:
        # A person may quit once all planned aliens are hit.
        return rule_violation(demonstration.plan, hits)
    return plan_violation(demonstration.plan, GameOutcome(hits, end, demonstration.replay.n_frames))


def example_tasks(
    behaviour: Behaviour,
    rng: np.random.Generator,
    n_perfect: int = N_PERFECT,
    kind: ExampleKind = SCRIPTED,
) -> list[DemonstrationTask]:
    """Return the tasks of an example: the demonstrations to rank, then perfect ones.

    Raises:
        Invalid: The demonstrator can't show this behaviour.
    """
    ranked = kind.plans(behaviour)
    plans = [*ranked, *[example_plans(behaviour)[0]] * n_perfect]
    starts = rng.permutation(TRAINING_IDLE_FRAMES).tolist()
    seeds = rng.integers(2**63, size=len(plans)).tolist()
    return [
        DemonstrationTask(
            plan,
            index >= len(ranked),
            # Disjoint starts, as far as there are enough.
            tuple(starts[index :: len(plans)]) or (starts[index % len(starts)],),
            seed,
            kind.error_model,
            kind.best_efforts,
        )
        for index, (plan, seed) in enumerate(zip(plans, seeds, strict=True))
    ]


def execute(tasks: Sequence[DemonstrationTask], n_processes: int = 1) -> Iterator[Demonstration]:
    """Execute tasks, in this process or in others, and yield the demonstrations in order.

    The result does not depend on the number of processes. Closing the iterator ends the work.

    Raises:
        DemonstrationFailed: No game fulfilled a plan.
    """
    pool = None if n_processes == 1 else _pool(n_processes)
    if pool is None:
        yield from map(_execute, tasks)
        return
    try:
        yield from pool.map(_execute, tasks)
    finally:
        pool.shutdown(cancel_futures=True)


def _pool(n_processes: int) -> ProcessPoolExecutor | None:
    """Start processes; None where there can be none, since their locks need /dev/shm."""
    try:
        # Spawned: a fork would copy the locks of this process's threads.
        return ProcessPoolExecutor(n_processes, mp_context=get_context("spawn"))
    except OSError as error:
        _LOG.warning("Demonstrations are played in one process, without /dev/shm: %s.", error)
        return None


def _execute(task: DemonstrationTask) -> Demonstration:
    rng = np.random.default_rng(task.seed)
    reason = ""
    n_attempts = MAX_ATTEMPTS if task.error_model == PERFECT else MAX_HUMAN_ATTEMPTS
    for attempt in range(n_attempts):
        start = AtariStart(task.idle_frames[attempt % len(task.idle_frames)])
        style = draw_brisk_style(rng) if task.perfect else draw_style(rng)
        try:
            return demonstrate(
                task.plan,
                start,
                rng,
                _console(),
                style,
                task.error_model,
                task.perfect,
                task.best_effort,
            )
        except DemonstrationFailed as failure:
            reason = str(failure)
    raise DemonstrationFailed(
        f"The demonstrator failed to show {task.plan.description!r} in {n_attempts} games."
        f" {reason} Try another training seed, or play it yourself."
    )


@cache
def _console() -> Console:
    """This process's console for demonstrations."""
    # An emulator alive at interpreter exit is reported as leaked.
    atexit.register(_console.cache_clear)
    return SPACE_INVADERS.make_console()
