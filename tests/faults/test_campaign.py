"""The short form of ``python -m benchmarks.faults``."""

from __future__ import annotations

from pathlib import Path

import pytest

from testsupport.faults.campaign import run_campaign
from testsupport.faults.plan import Plan

KILLS = ("kill server", "kill worker", "kill inference")


@pytest.mark.lengthy
@pytest.mark.timeout(1800)
def test_kills_of_each_process_lose_nothing_that_was_acknowledged(tmp_path: Path) -> None:
    plan = Plan(
        n_faults=len(KILLS),
        seed=1,
        n_workers=1,
        kinds=KILLS,
        in_turn=True,
        quiet_s=(0.5, 1.5),
        steps=(128,),
        runs_at_once=1,
        n_runs=1,
    )
    result = run_campaign(plan, tmp_path)
    assert result.violations == []
    assert sorted(fault.kind for fault in result.history.faults) == sorted(KILLS)
    assert result.answers["acknowledged"] > 20
    assert result.runs
