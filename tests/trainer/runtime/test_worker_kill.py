"""A worker that is killed loses nothing but time."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest

from testsupport.worker_kills import finish, flaws, kill_and_finish
from testsupport.worker_zygote import Zygote
from testsupport.workplace import TINY, Workplace
from tril.jobs import Jobs
from tril.store import recordings
from tril.store.training.evaluations import ACTION_SELECTIONS, POLICIES

N_KILLS = 6
LONGEST_LIFE = 0.6
"""Of a worker, as a share of what a run takes that nothing happens to."""

LONGEST_LIFE_S = 3.0
"""Keeps the test short on a machine that has other work; it then kills in fewer stages."""


@pytest.mark.lengthy
@pytest.mark.timeout(900)
def test_kills_in_the_middle_of_short_runs_leave_every_run_finished_and_whole(
    workplace: Workplace, jobs: Jobs, zygote: Zygote
) -> None:
    untouched = workplace.make_run(TINY)
    jobs.enqueue(untouched)
    run_s = finish(workplace, zygote, [untouched])
    longest_life_s = min(LONGEST_LIFE_S, LONGEST_LIFE * run_s)
    rng = np.random.default_rng(20)
    outcome = kill_and_finish(workplace, jobs, zygote, N_KILLS, longest_life_s, rng)
    print(Counter(outcome.killed_in), f"{len(outcome.runs)} runs, {outcome.seconds:.0f} s")
    assert len(outcome.killed_in) == N_KILLS
    for run_id in outcome.runs:
        assert flaws(workplace, run_id, untouched) == []
    with workplace.database.reading() as session:
        played = recordings.listing(session, workplace.behaviour_id, with_policies=True)
    of_runs = Counter(row.run_id for row in played if row.run_id is not None)
    games = len(POLICIES) * len(ACTION_SELECTIONS) * len(TINY.evaluation.start_numbers)
    assert set(of_runs.values()) == {games}, "A killed evaluation left a game twice."
