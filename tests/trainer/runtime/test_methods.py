"""A run whose imitator is not trained on the learned reward, through real worker processes."""

from __future__ import annotations

from pathlib import Path

import pytest
from stable_baselines3 import PPO

from testsupport.waiting import wait_until
from testsupport.worker_kills import PATIENCE_S, curve_flaws, curves_of, finish
from testsupport.worker_zygote import Zygote
from testsupport.workplace import TINY, Workplace
from tril.jobs import Jobs
from tril.recipes import GAIL, with_values
from tril.stages import stages_of
from tril.store.models import RunStatus
from tril.store.training import artifacts, evaluations

STEPS = 400

TINY_GAIL = with_values(
    TINY,
    {
        "method": "gail",
        "gail.updates": 2,
        "policy.reward": GAIL.policy.reward,
        "policy.reward_scale": GAIL.policy.reward_scale,
        "policy.death_forfeit": GAIL.policy.death_forfeit,
        "policy.snapshot_steps": GAIL.policy.snapshot_steps,
    },
)
OWN_CURVES = {"discriminator_loss", "discriminator_accuracy", "value_loss", "entropy"}


@pytest.mark.lengthy
@pytest.mark.timeout(1200)
def test_a_run_is_finished_and_one_that_is_killed_learns_the_same(
    workplace: Workplace, jobs: Jobs, zygote: Zygote
) -> None:
    untouched = workplace.make_run(TINY_GAIL, STEPS)
    jobs.enqueue(untouched)
    finish(workplace, zygote, [untouched])
    row = workplace.run(untouched)
    assert row.status == RunStatus.DONE, row.message
    assert tuple(row.finished_stages) == stages_of(example=False)
    assert set(curves_of(workplace, untouched)["imitator"]) >= OWN_CURVES
    check_results(workplace, untouched)

    killed = workplace.make_run(TINY_GAIL, STEPS)
    jobs.enqueue(killed)
    with zygote.running(workplace.settings.data):
        wait_until(lambda: bool(curves_of(workplace, killed).get("imitator")))
    row = workplace.run(killed)
    assert (row.status, row.stage) == (RunStatus.RUNNING, "imitator")
    # What follows needs the imitator alone, by whatever method it was trained.
    with zygote.running(workplace.settings.data):
        wait_until(lambda: "imitator" in workplace.run(killed).finished_stages, PATIENCE_S)
    assert workplace.run(killed).epoch == 2
    assert curve_flaws(workplace, killed, untouched) == []


def check_results(workplace: Workplace, run_id: str) -> None:
    with workplace.database.reading() as session:
        games = evaluations.listing(session, run_id)
        files = {file.name: file for file in artifacts.listing(session, run_id)}
    assert {game.policy for game in games} == set(evaluations.POLICIES)
    root = Path(workplace.settings.artifact_root)
    PPO.load(root / files["imitator.zip"].path)
    summary = (root / files["summary.md"].path).read_text()
    assert f"{STEPS:,} steps" in summary
