"""Kill workers at random moments and compare what is left with a run left alone."""

from __future__ import annotations

import time
from dataclasses import dataclass, field
from functools import partial

import numpy as np

from testsupport.waiting import wait_until
from testsupport.worker_zygote import Zygote
from testsupport.workplace import TINY, Workplace
from tril.jobs import Jobs
from tril.recipes import Recipe
from tril.store.models import RunRow, RunStatus
from tril.store.training import evaluations, metrics
from tril.store.training.metrics import Series

PATIENCE_S = 600.0


@dataclass
class Outcome:
    """What came of the kills.

    Attributes:
        runs: The runs that were killed at, all of them over.
        killed_in: For each kill the stage at work, "" where the worker had not begun.
        seconds: How long it all took.
    """

    runs: list[str] = field(default_factory=list)
    killed_in: list[str] = field(default_factory=list)
    seconds: float = 0.0


def kill_and_finish(
    workplace: Workplace,
    jobs: Jobs,
    zygote: Zygote,
    n_kills: int,
    longest_life_s: float,
    rng: np.random.Generator,
    recipe: Recipe = TINY,
    steps: int = 256,
) -> Outcome:
    """Kill workers by SIGKILL while they have a run, then let one finish what is left.

    Args:
        workplace: Where.
        jobs: Its queue.
        zygote: Starts workers.
        n_kills: How many kills.
        longest_life_s: Each worker lives for a random time up to this after it has the run.
        rng: Where those times come from.
        recipe: What the runs learn by.
        steps: Their PPO steps.
    """
    began = time.monotonic()
    outcome = Outcome()
    while len(outcome.killed_in) < n_kills:
        if not outcome.runs or is_over(workplace, outcome.runs[-1]):
            run_id = workplace.make_run(recipe, steps)
            outcome.runs.append(run_id)
            jobs.enqueue(run_id)
        before = workplace.run(outcome.runs[-1])
        with zygote.running(workplace.settings.data):
            wait_until(partial(is_leased_since, workplace, before), PATIENCE_S)
            time.sleep(rng.uniform(0.0, longest_life_s))
        row = workplace.run(outcome.runs[-1])
        if not RunStatus(row.status).is_over:
            outcome.killed_in.append(row.stage)
    finish(workplace, zygote, outcome.runs)
    outcome.seconds = time.monotonic() - began
    return outcome


def finish(workplace: Workplace, zygote: Zygote, run_ids: list[str]) -> float:
    """Let one worker finish these runs; returns the seconds it took."""
    began = time.monotonic()
    with zygote.running(workplace.settings.data):
        wait_until(lambda: all(is_over(workplace, run_id) for run_id in run_ids), PATIENCE_S)
    return time.monotonic() - began


def is_leased_since(workplace: Workplace, before: RunRow) -> bool:
    """Whether a run was leased since its row was read."""
    return workplace.run(before.id).epoch > before.epoch


def is_over(workplace: Workplace, run_id: str) -> bool:
    """Whether a run is over."""
    return RunStatus(workplace.run(run_id).status).is_over


def curves_of(workplace: Workplace, run_id: str) -> Series:
    """Return a run's curves."""
    with workplace.database.reading() as session:
        return metrics.series(session, run_id)[1]


def curve_flaws(workplace: Workplace, run_id: str, untouched: str) -> list[str]:
    """Compare the curves of a run with those of one that nothing happened to."""
    ours, theirs = curves_of(workplace, run_id), curves_of(workplace, untouched)
    return [
        f"The curve {stage}.{name} is {ours.get(stage, {}).get(name)}, not {points}."
        for stage, series in theirs.items()
        for name, points in series.items()
        if name != "steps_per_s" and ours.get(stage, {}).get(name) != points
    ]


def flaws(workplace: Workplace, run_id: str, untouched: str) -> list[str]:
    """Compare a run with one of the same making that nothing happened to; returns what is wrong.

    Both learn from the same training seed, so their curves are the same, point by point and bit by
    bit, whatever happened on the way.
    """
    row, other = workplace.run(run_id), workplace.run(untouched)
    found = curve_flaws(workplace, run_id, untouched)
    if row.status != RunStatus.DONE:
        found.append(f"The run is {row.status}: {row.message}")
    if set(row.finished_stages) != set(other.finished_stages):
        found.append(f"Its stages are {sorted(row.finished_stages)}.")
    with workplace.database.reading() as session:
        games = {
            (game.policy, game.action_selection, game.start_number)
            for game in evaluations.listing(session, run_id)
        }
        if len(evaluations.listing(session, run_id)) != len(games) or len(games) != len(
            evaluations.listing(session, untouched)
        ):
            found.append(f"Its evaluation games are {sorted(games)}.")
    return found
