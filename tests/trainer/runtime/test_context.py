"""What a stage reports, and when it is told to stop."""

from __future__ import annotations

import threading

import pytest

from testsupport.workplace import Workplace
from trainer.progress import RunCancelled
from trainer.runtime.context import RunContext, StageProgress, WorkerStopping
from tril.files.artifact_store import ArtifactStore
from tril.jobs import RunEta
from tril.recipes import recipe_from_dict
from tril.stages import Stage
from tril.store import behaviours
from tril.store.training import metrics, runs
from tril.store.training.leases import LeaseLost

STAGE = Stage.IMITATOR


class Clock:
    """A clock that is set by hand."""

    def __init__(self) -> None:
        self.now = 0.0

    def __call__(self) -> float:
        return self.now


@pytest.fixture
def run_id(workplace: Workplace) -> str:
    return workplace.make_run(steps=1000)


def leased(workplace: Workplace, run_id: str) -> RunContext:
    lease = workplace.lease(run_id)
    with workplace.database.reading() as session:
        run = runs.get(session, run_id)
        return RunContext(
            lease=lease,
            run=run,
            behaviour=behaviours.as_behaviour(behaviours.get(session, run.behaviour_id)),
            recipe=recipe_from_dict(run.recipe),
            database=workplace.database,
            artifacts=ArtifactStore(workplace.settings.artifact_root),
            folder=workplace.settings.data / "runs" / run_id,
            settings=workplace.settings,
            eta=RunEta({"reward": 50.0, STAGE: 100.0, "evaluation": 30.0}),
            threads=1,
            stopping=threading.Event(),
        )


def curve(workplace: Workplace, run_id: str) -> list[tuple[int, float]]:
    with workplace.database.reading() as session:
        return metrics.series(session, run_id)[1].get(STAGE, {}).get("kl", [])


def test_points_and_progress_are_on_the_row_when_they_come_slowly(
    workplace: Workplace, run_id: str
) -> None:
    clock = Clock()
    progress = StageProgress(leased(workplace, run_id), STAGE, clock)
    for done in (100, 200, 300):
        clock.now += 5.0
        progress.advance(done, 1000, {"kl": done / 1000})
        assert curve(workplace, run_id)[-1] == (done, done / 1000)
    row = workplace.run(run_id)
    assert row.stage == STAGE
    assert row.stage_done == pytest.approx(0.3)
    # It counts down from the first estimate: what was learned since is less than a minute.
    assert row.remaining_s == pytest.approx(90.0 + 30.0 + 50.0 - 10.0)


def test_nothing_remains_known_of_a_stage_that_gets_no_further(
    workplace: Workplace, run_id: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    clock = Clock()
    monkeypatch.setattr("trainer.runtime.context.time.monotonic", clock)
    context = leased(workplace, run_id)
    progress = StageProgress(context, STAGE, clock)
    progress.advance(0, 1000)
    clock.now += 10.0
    progress.advance(1, 1000, {"kl": 0.0})
    assert workplace.run(run_id).remaining_s == pytest.approx(0.999 * 100.0 + 30.0 + 50.0)
    clock.now += 25.0
    # Its speed is still unknown, but it moves.
    progress.advance(2, 1000, {"kl": 0.0})
    assert workplace.run(run_id).remaining_s == pytest.approx(0.999 * 100.0 + 30.0 + 50.0 - 25.0)
    progress.advance(300, 1000, {"kl": 0.0})
    known = workplace.run(run_id).remaining_s
    assert known is not None
    for waited_s, expected in ((29.0, known), (2.0, None)):
        clock.now += waited_s
        with workplace.database.writing() as session:
            context.beat(session)
        assert workplace.run(run_id).remaining_s == expected
    progress.advance(300, 1000, {"kl": 1.0})
    assert workplace.run(run_id).remaining_s is None
    progress.advance(310, 1000, {"kl": 1.0})
    assert workplace.run(run_id).remaining_s is not None


def test_points_are_written_at_once_and_mere_progress_once_a_second(
    workplace: Workplace, run_id: str
) -> None:
    clock = Clock()
    progress = StageProgress(leased(workplace, run_id), STAGE, clock)
    for done in range(1, 11):
        clock.now += 0.01
        progress.advance(done, 1000, {"kl": float(done)})
    assert curve(workplace, run_id) == [(done, float(done)) for done in range(1, 11)]
    clock.now += 0.9
    progress.advance(500, 1000)
    assert workplace.run(run_id).stage_done == pytest.approx(0.01)
    clock.now += 0.2
    progress.advance(600, 1000)
    assert workplace.run(run_id).stage_done == pytest.approx(0.6)


def test_going_on_from_a_checkpoint_leaves_a_curve_without_jump_or_gap(
    workplace: Workplace, run_id: str
) -> None:
    clock = Clock()
    first = StageProgress(leased(workplace, run_id), STAGE, clock)
    for done in (100, 200, 300, 400):
        clock.now += 1.0
        first.advance(done, 1000, {"kl": 1.0})
    # Killed; the checkpoint was made at 200.
    second = StageProgress(leased(workplace, run_id), STAGE, clock)
    second.advance(200, 1000)
    assert curve(workplace, run_id) == [(100, 1.0), (200, 1.0)]
    for done in (300, 400):
        clock.now += 1.0
        second.advance(done, 1000, {"kl": 2.0})
    assert curve(workplace, run_id) == [(100, 1.0), (200, 1.0), (300, 2.0), (400, 2.0)]
    # The time of the whole stage is told by the part that was measured.
    assert second.seconds() == pytest.approx(2.0 / 0.8)


def test_a_cancelled_run_stops_at_the_next_report(workplace: Workplace, run_id: str) -> None:
    context = leased(workplace, run_id)
    progress = StageProgress(context, STAGE)
    with workplace.database.writing() as session:
        runs.request_cancel(session, run_id)
    with pytest.raises(RunCancelled) as caught:
        progress.advance(1, 1000)
    assert not isinstance(caught.value, WorkerStopping)


def test_the_row_is_looked_at_once_a_second_at_most(
    workplace: Workplace, run_id: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    context = leased(workplace, run_id)
    clock = Clock()
    monkeypatch.setattr("trainer.runtime.context.time.monotonic", clock)
    context.check_cancelled()
    with workplace.database.writing() as session:
        runs.request_cancel(session, run_id)
    clock.now += 0.9
    context.check_cancelled()
    clock.now += 0.2
    with pytest.raises(RunCancelled):
        context.check_cancelled()


def test_a_stopping_worker_leaves_at_once(workplace: Workplace, run_id: str) -> None:
    context = leased(workplace, run_id)
    context.stopping.set()
    with pytest.raises(WorkerStopping):
        StageProgress(context, STAGE).advance(1, 1000)


def test_a_worker_that_lost_its_run_writes_nothing_more(workplace: Workplace, run_id: str) -> None:
    lost = leased(workplace, run_id)
    progress = StageProgress(lost, STAGE)
    progress.advance(100, 1000, {"kl": 1.0})
    leased(workplace, run_id)
    with pytest.raises(LeaseLost):
        StageProgress(lost, STAGE).advance(500, 1000, {"kl": 9.0})
    with pytest.raises(LeaseLost):
        lost.save_artifact("figure", "x.png", "image/png", b"")
    with pytest.raises(LeaseLost):
        lost.finish_stage(STAGE, 1.0)
    assert curve(workplace, run_id) == [(100, 1.0)]
    assert not lost.artifacts.exists(f"runs/{run_id}/x.png")
