"""Making demonstrations: games of the scripted player that meet their plans."""

from __future__ import annotations

import atexit
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import cache
from multiprocessing import get_context
from typing import Any

import numpy as np

from tril.behaviours import Behaviour
from tril.demonstrator.judging import Judgement, ShownGame, judge
from tril.demonstrator.kinds import SCRIPTED, ExampleKind
from tril.demonstrator.manner import PERFECT, Manner
from tril.demonstrator.person import PersonLikePlayer
from tril.demonstrator.plans import (
    DemonstrationPlan,
    PlayedGame,
    comes_near,
    draw_hits,
    example_plans,
    meets,
    shows,
)
from tril.demonstrator.player import ScriptedPlayer, Style, draw_brisk_style, draw_style
from tril.errors import Unavailable
from tril.game.console import Console
from tril.game.episode import TRAINING_IDLE_FRAMES, Episode, Start
from tril.recording import Recorder, Recording, Replay

N_PERFECT = 12
"""Perfect demonstrations of an example, for the clone."""
MAX_ATTEMPTS = 12
"""Games in which a plan has to come off; about 4 of 5 do where it is hardest."""
MAX_ATTEMPTS_OF_A_PERSON = 300
"""The same for games that are not played flawlessly. They take a quarter of the time, since nothing
is tried out; of perfect games of column 6 about 1 in 10 comes off."""


_MISTAKES = 3
"""Sets the chance of ranking mistakes apart from that of the games of the same seed."""


class DemonstrationFailed(Unavailable):
    """No game of the scripted player met the plan."""


@dataclass(frozen=True)
class Demonstration:
    """A game of the scripted player that met its plan, or came near it as a person's game does.

    Attributes:
        recording: The game.
        replay: What a replay of it gives.
        plan: What it was to show.
        perfect: Whether it is made for the clone to learn from, and not ranked.
        manner: How it was played.
    """

    recording: Recording
    replay: Replay
    plan: DemonstrationPlan
    perfect: bool = False
    manner: Manner = PERFECT

    @property
    def shown(self) -> ShownGame:
        """What it turned out to show."""
        hits = tuple((hit.row, hit.column) for hit in self.replay.hits)
        return ShownGame(self.plan.number, hits, self.replay.end)

    @property
    def notes(self) -> str:
        """What it shows, in words, or was to show where it only has to come near."""
        meant = self.manner != PERFECT and not self.perfect
        return f"Meant as: {self.plan.description}" if meant else self.plan.description

    @property
    def conditions(self) -> dict[str, Any]:
        """How it was played, for a recording's conditions; empty where flawlessly."""
        return {} if self.manner == PERFECT else {"manner": self.manner.to_dict()}


@dataclass(frozen=True)
class Task:
    """A demonstration to be made. Tasks are independent of each other and of their order.

    Attributes:
        plan: What to show.
        perfect: Whether it is for the clone.
        idle_frames: The starts to try, in turn.
        chance: Seeds the game's chances.
        manner: How to play.
    """

    plan: DemonstrationPlan
    perfect: bool
    idle_frames: tuple[int, ...]
    chance: int
    manner: Manner = PERFECT


def demonstrate(
    plan: DemonstrationPlan,
    start: Start,
    rng: np.random.Generator,
    console: Console | None = None,
    style: Style | None = None,
    manner: Manner = PERFECT,
    perfect: bool = False,
) -> Demonstration:
    """Play one game that shows a plan.

    A flawless player has to meet the plan and to survive. Of another it is enough to come near it,
    hit by a bomb or not; but a perfect game meets its plan and is survived, whoever plays it.

    Args:
        plan: What to show.
        start: How the game begins.
        rng: Where the player's chances come from.
        console: The console to play on; None loads one.
        style: How to play; None draws one.
        manner: How well to play.
        perfect: Whether it is for the clone to learn from.

    Raises:
        DemonstrationFailed: The game doesn't show the plan.
    """
    recorder = Recorder(Episode(console or Console(), start))
    wanted = draw_hits(plan, rng)
    style = style or draw_style(rng)
    if manner == PERFECT:
        ScriptedPlayer(recorder, wanted, style, rng).play()
    else:
        PersonLikePlayer(recorder, wanted, style, manner, rng).play()
    made = Demonstration(recorder.recording(), recorder.replay(), plan, perfect, manner)
    if reason := _why_not(made):
        raise DemonstrationFailed(reason)
    return made


def _why_not(made: Demonstration) -> str | None:
    """Say why a game is no demonstration of its plan; None if it is."""
    hits, end = made.shown.hits, made.replay.end
    if made.manner != PERFECT and not made.perfect:
        return comes_near(made.plan, hits)
    if made.manner != PERFECT and end is None:
        # A person leaves a game when all is shown.
        return meets(made.plan, hits)
    return shows(made.plan, PlayedGame(hits, end, made.replay.n_frames))


def example_tasks(
    behaviour: Behaviour,
    rng: np.random.Generator,
    n_perfect: int = N_PERFECT,
    kind: ExampleKind = SCRIPTED,
) -> list[Task]:
    """What has to be made for an example: the demonstrations to rank, then perfect ones.

    Raises:
        Invalid: The demonstrator can't show this behaviour.
    """
    plans = kind.plans(behaviour)
    best = example_plans(behaviour)[0]
    return _tasks([*plans, *[best] * n_perfect], len(plans), rng, kind.manner)


def make_example(
    behaviour: Behaviour,
    rng: np.random.Generator,
    n_perfect: int = N_PERFECT,
    n_processes: int = 1,
    kind: ExampleKind = SCRIPTED,
) -> Iterator[Demonstration]:
    """Make the example of a behaviour: the demonstrations to rank, then perfect ones.

    The result depends on the generator alone, not on the number of processes. Closing the iterator
    ends the work.

    Args:
        behaviour: What to show.
        rng: Where starts and chances come from.
        n_perfect: How many perfect demonstrations to add.
        n_processes: Processes to play in; 1 plays in this one.
        kind: Which demonstrations, and how they are played.

    Yields:
        Each demonstration when it is done, the best plan first.

    Raises:
        Invalid: The demonstrator can't show this behaviour.
        DemonstrationFailed: A plan didn't come off.
    """
    yield from carry_out(example_tasks(behaviour, rng, n_perfect, kind), n_processes)


def judge_example(
    behaviour: Behaviour,
    kind: ExampleKind,
    games: Mapping[int, ShownGame],
    example_seed: int,
) -> Judgement:
    """Rank the ranked demonstrations of an example, as its kind has it.

    Args:
        behaviour: What they show.
        kind: Their kind.
        games: What they show, by the ids to rank.
        example_seed: Seeds the ranking mistakes.
    """
    return judge(behaviour, kind, games, np.random.default_rng([_MISTAKES, example_seed]))


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
    plans: Sequence[DemonstrationPlan],
    n_ranked: int,
    rng: np.random.Generator,
    manner: Manner = PERFECT,
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
            manner,
        )
        for number, (plan, chance) in enumerate(zip(plans, chances, strict=True))
    ]


def _carried_out(task: Task) -> Demonstration:
    rng = np.random.default_rng(task.chance)
    reason = ""
    n_attempts = MAX_ATTEMPTS if task.manner == PERFECT else MAX_ATTEMPTS_OF_A_PERSON
    for attempt in range(n_attempts):
        start = Start(task.idle_frames[attempt % len(task.idle_frames)])
        style = draw_brisk_style(rng) if task.perfect else draw_style(rng)
        try:
            return demonstrate(task.plan, start, rng, _console(), style, task.manner, task.perfect)
        except DemonstrationFailed as failure:
            reason = str(failure)
    raise DemonstrationFailed(
        f"The demonstrator did not manage {task.plan.description!r} in {n_attempts} games."
        f" {reason} Try another training seed, or play it yourself."
    )


@cache
def _console() -> Console:
    """This process's console for demonstrations."""
    # An emulator that is still there when the interpreter goes is reported as leaked.
    atexit.register(_console.cache_clear)
    return Console()
