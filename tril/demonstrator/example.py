"""Making demonstrations: games of the scripted player that meet their plans."""

from __future__ import annotations

import atexit
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import cache
from multiprocessing import get_context
from typing import Any

import numpy as np

from tril.behaviours import Behaviour
from tril.demonstrator.plans import DemonstrationPlan, draw_hits, example_plans, meets
from tril.demonstrator.player import ScriptedPlayer, Style, draw_brisk_style, draw_style
from tril.errors import Unavailable
from tril.exchange import to_exchange
from tril.game.console import Console
from tril.game.episode import TRAINING_IDLE_FRAMES, EndReason, Episode, Start
from tril.recording import Recorder, Recording, Replay

N_PERFECT = 12
"""Perfect demonstrations of an example, for the clone."""
MAX_ATTEMPTS = 12
"""Games in which a plan has to come off; about 4 of 5 do where it is hardest."""


class DemonstrationFailed(Unavailable):
    """No game of the scripted player met the plan."""


@dataclass(frozen=True)
class Demonstration:
    """A game of the scripted player that met its plan and that it survived.

    Attributes:
        recording: The game.
        replay: What a replay of it gives.
        plan: What it shows; the plan's number is its tier.
        perfect: Whether it is made for the clone to learn from, and not ranked.
    """

    recording: Recording
    replay: Replay
    plan: DemonstrationPlan
    perfect: bool = False

    def to_exchange(self) -> dict[str, Any]:
        """The demonstration in the exchange format."""
        return to_exchange(
            self.recording,
            hits=self.replay.hits,
            end=self.replay.end,
            tier=None if self.perfect else self.plan.number,
            perfect=self.perfect,
            source="scripted",
            notes=self.plan.description,
        )


@dataclass(frozen=True)
class Task:
    """A demonstration to be made. Tasks are independent of each other and of their order.

    Attributes:
        plan: What to show.
        perfect: Whether it is for the clone.
        idle_frames: The starts to try, in turn.
        chance: Seeds the game's chances.
    """

    plan: DemonstrationPlan
    perfect: bool
    idle_frames: tuple[int, ...]
    chance: int


def demonstrate(
    plan: DemonstrationPlan,
    start: Start,
    rng: np.random.Generator,
    console: Console | None = None,
    style: Style | None = None,
) -> Demonstration:
    """Play one game that shows a plan.

    Args:
        plan: What to show.
        start: How the game begins.
        rng: Where the player's chances come from.
        console: The console to play on; None loads one.
        style: How to play; None draws one.

    Raises:
        DemonstrationFailed: The game doesn't meet the plan, or the player was hit.
    """
    recorder = Recorder(Episode(console or Console(), start))
    wanted = draw_hits(plan, rng)
    ScriptedPlayer(recorder, wanted, style or draw_style(rng), rng).play()
    played = recorder.replay()
    reason = meets(plan, [(hit.row, hit.column) for hit in played.hits])
    if played.end not in (EndReason.STEPS, EndReason.CLEARED):
        reason = f"The game ended at frame {played.n_frames}: {played.end}."
    if reason:
        raise DemonstrationFailed(reason)
    return Demonstration(recorder.recording(), played, plan)


def example_tasks(
    behaviour: Behaviour, rng: np.random.Generator, n_perfect: int = N_PERFECT
) -> list[Task]:
    """What has to be made for an example: the twelve demonstrations to rank, then perfect ones.

    Raises:
        Invalid: The demonstrator can't show this behaviour.
    """
    plans = example_plans(behaviour)
    return _tasks([*plans, *[plans[0]] * n_perfect], len(plans), rng)


def make_example(
    behaviour: Behaviour,
    rng: np.random.Generator,
    n_perfect: int = N_PERFECT,
    n_processes: int = 1,
) -> Iterator[Demonstration]:
    """Make the example of a behaviour: the twelve demonstrations to rank, then perfect ones.

    The result depends on the generator alone, not on the number of processes. Closing the iterator
    ends the work.

    Args:
        behaviour: What to show.
        rng: Where starts and chances come from.
        n_perfect: How many perfect demonstrations to add.
        n_processes: Processes to play in; 1 plays in this one.

    Yields:
        Each demonstration when it is done, the best plan first.

    Raises:
        Invalid: The demonstrator can't show this behaviour.
        DemonstrationFailed: A plan didn't come off.
    """
    yield from carry_out(example_tasks(behaviour, rng, n_perfect), n_processes)


def perfect_demonstrations(
    behaviour: Behaviour, count: int, rng: np.random.Generator, n_processes: int = 1
) -> Iterator[Demonstration]:
    """Make different perfect demonstrations: all targets, no strays, alive at the end.

    Args and errors as of make_example.
    """
    tasks = _tasks([example_plans(behaviour)[0]] * count, 0, rng)
    yield from carry_out(tasks, n_processes)


def carry_out(tasks: Sequence[Task], n_processes: int = 1) -> Iterator[Demonstration]:
    """Make demonstrations, in this process or in others, and yield them in order."""
    if n_processes == 1:
        yield from map(_carried_out, tasks)
        return
    # Spawned, since a fork would copy the locks of this process's threads.
    pool = ProcessPoolExecutor(n_processes, mp_context=get_context("spawn"))
    try:
        yield from pool.map(_carried_out, tasks)
    finally:
        pool.shutdown(cancel_futures=True)


def _tasks(
    plans: Sequence[DemonstrationPlan], n_ranked: int, rng: np.random.Generator
) -> list[Task]:
    """Tasks with starts of their own, as far as there are enough."""
    starts = rng.permutation(TRAINING_IDLE_FRAMES).tolist()
    chances = rng.integers(2**63, size=len(plans)).tolist()
    return [
        Task(
            plan,
            number >= n_ranked,
            tuple(starts[number :: len(plans)]) or (starts[number % len(starts)],),
            chance,
        )
        for number, (plan, chance) in enumerate(zip(plans, chances, strict=True))
    ]


def _carried_out(task: Task) -> Demonstration:
    rng = np.random.default_rng(task.chance)
    reason = ""
    for attempt in range(MAX_ATTEMPTS):
        start = Start(task.idle_frames[attempt % len(task.idle_frames)])
        style = draw_brisk_style(rng) if task.perfect else draw_style(rng)
        try:
            made = demonstrate(task.plan, start, rng, _console(), style)
        except DemonstrationFailed as failure:
            reason = str(failure)
        else:
            return Demonstration(made.recording, made.replay, made.plan, task.perfect)
    raise DemonstrationFailed(
        f"The demonstrator did not manage {task.plan.description!r} in {MAX_ATTEMPTS} games."
        f" {reason} Try another training seed, or play it yourself."
    )


@cache
def _console() -> Console:
    """This process's console for demonstrations."""
    # An emulator that is still there when the interpreter goes is reported as leaked.
    atexit.register(_console.cache_clear)
    return Console()
