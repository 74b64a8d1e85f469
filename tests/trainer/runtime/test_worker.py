"""Whole runs through real worker processes."""

from __future__ import annotations

import io
import itertools
import os
import signal
import subprocess
import sys
import tarfile
import time
from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from typing import Any

import psutil
import pytest
from sqlalchemy import select, text, update
from sqlalchemy.exc import OperationalError
from stable_baselines3 import PPO

from testsupport import s3
from testsupport.waiting import wait_until
from testsupport.worker_zygote import WorkerProcess, Zygote
from testsupport.workplace import TINY, Workplace
from trainer.reward.model import RewardModel
from trainer.runtime.pipeline import LEASE_LOST, LEFT
from tril.cores import core_count
from tril.files.artifact_store import ArtifactStore
from tril.games.space_invaders import SPACE_INVADERS
from tril.games.space_invaders.ends import Ending, EndReason
from tril.jobs import Jobs, overall_progress
from tril.jobs.delivery import LOST_AFTER_S
from tril.recipes import evaluated_on_own_start, with_values
from tril.recording import verify
from tril.stages import stages_of
from tril.store import processes, recordings
from tril.store.models import MetricRow, ProcessRow, RunDevice, RunRow, RunStatus
from tril.store.training import artifacts, evaluations, metrics, runs

SOON_S = 3.0
"""Seconds after which a test's worker gives another one up."""

CONFUSED = with_values(
    TINY, {"reward.method": "paper", "reward.updates": 1, "reward.learning_rate": 1e-9}
)
"""Its reward model learns nothing and orders the demonstrations by chance."""

WRONG = 3
"""A training seed for which chance orders them wrongly (tau is -0.33)."""


def until(what: Callable[[], bool], worker: WorkerProcess | None = None) -> None:
    wait_until(what, what_was_said=lambda: worker.log.read_text()[-3000:] if worker else "")


def until_over(workplace: Workplace, run_id: str, worker: WorkerProcess) -> RunRow:
    until(lambda: RunStatus(workplace.run(run_id).status).is_over, worker)
    return workplace.run(run_id)


def is_in(workplace: Workplace, run_id: str, stage: str) -> bool:
    row = workplace.run(run_id)
    return row.status == RunStatus.RUNNING and row.stage == stage and row.stage_done > 0


def test_a_policy_judged_where_it_was_trained_claims_nothing_held_out(
    workplace: Workplace, jobs: Jobs, zygote: Zygote
) -> None:
    recipe = with_values(evaluated_on_own_start(TINY, 1), {"ending": "life_counter"})
    run_id = workplace.make_run(recipe, steps=64)
    jobs.enqueue(run_id)
    with zygote.running(workplace.settings.data) as worker:
        row = until_over(workplace, run_id, worker)
        assert row.status == RunStatus.DONE, worker.log.read_text()
    with workplace.database.reading() as session:
        games = evaluations.listing(session, run_id)
        assert {(game.start_number, game.held_out) for game in games} == {(1, False)}
        # The recordings are those of the whole games, which end by the recipe's rule.
        for game in games:
            recording = recordings.as_recording(game.recording)
            assert recording.end_rule == Ending.LIFE_COUNTER
            assert verify(recording).replay.end == game.recording.end != EndReason.HIT
    assert row.outcome.headline is not None
    assert row.outcome.headline.imitator is None


@pytest.mark.lengthy
def test_a_run_goes_through_all_stages_and_leaves_its_results(
    workplace: Workplace, jobs: Jobs, zygote: Zygote
) -> None:
    run_id = workplace.make_run()
    jobs.enqueue(run_id)
    scratch = workplace.settings.data / "runs" / run_id
    with zygote.running(workplace.settings.data) as worker:
        row = until_over(workplace, run_id, worker)
        assert row.status == RunStatus.DONE, worker.log.read_text()
        until(lambda: not scratch.exists(), worker)
    assert tuple(row.finished_stages) == stages_of(example=False)
    assert row.epoch == 1
    with workplace.database.reading() as session:
        assert overall_progress(session, row) == 1.0
    assert row.remaining_s is None
    assert row.versions["torch"]
    assert row.versions["game"] == SPACE_INVADERS.name
    assert row.versions["game_version"] == SPACE_INVADERS.version
    assert row.versions["reward_inference"]
    check_results(workplace, row)


def check_results(workplace: Workplace, row: RunRow) -> None:
    with workplace.database.reading() as session:
        games = evaluations.listing(session, row.id)
        files = {file.name: file for file in artifacts.listing(session, row.id)}
        _, curves = metrics.series(session, row.id)
        library = recordings.listing(session, workplace.behaviour_id)
    assert {(game.policy, game.action_selection, game.start_number) for game in games} == {
        (policy, how, 0) for policy in evaluations.POLICIES for how in evaluations.ACTION_SELECTIONS
    }
    assert len(games) == 6
    for game in games:
        assert game.recording.conditions == {
            "policy": game.policy,
            "action_selection": game.action_selection,
            **({"sticky_action_probability": 0.25} if game.action_selection == "sticky" else {}),
        }
        assert game.held_out
        assert game.recording.run_id == row.id
        assert verify(recordings.as_recording(game.recording)).n_cut == 0
        assert game.targets is not None
    # What policies play is no part of the person's library.
    assert {one.id for one in library} == set(workplace.ranked)
    kinds = {file.kind for file in files.values()}
    assert {"reward_model", "imitator", "clone", "attention_map", "attention_red_blue"} <= kinds
    assert {"attention_frame", "figure", "summary"} <= kinds
    maps = [file for file in files.values() if file.kind == "attention_map"]
    assert [one.details["faithfulness"] is not None for one in maps] == [True] * 4
    root = Path(workplace.settings.artifact_root)
    model = RewardModel.load(root / files["reward-model.safetensors"].path)
    assert model.one > model.zero
    PPO.load(root / files["imitator.zip"].path)
    assert row.outcome.check is not None
    assert set(row.outcome.check.predicted_returns) == set(workplace.ranked)
    assert row.outcome.headline is not None
    assert row.outcome.headline.imitator is not None
    assert row.outcome.headline.imitator.steps.n == 1
    assert {"loss", "accuracy"} <= set(curves["clone"])
    assert curves["imitator"]["entropy"][-1][0] == row.steps
    steps = [step for step, _ in curves["imitator"]["entropy"]]
    assert steps == sorted(set(steps))


ENDLESS = 1_000_000

NEVER_ENDING: dict[str, dict[str, Any]] = {
    "reward": {"reward.updates": ENDLESS},
    "check": {"reward.folds": 2, "reward.fold_updates": ENDLESS},
    "clone": {
        "cloning.epochs": ENDLESS,
        "cloning.patience": ENDLESS,
        "cloning.validation_share": 0.0,
    },
    "imitator": {},
}
"""What makes each stage one that no test waits for."""


@pytest.mark.parametrize("stage", NEVER_ENDING)
def test_cancelling_takes_effect_within_5_s_in_every_stage_that_learns(
    workplace: Workplace, jobs: Jobs, zygote: Zygote, stage: str
) -> None:
    run_id = workplace.make_run(with_values(TINY, NEVER_ENDING[stage]), steps=ENDLESS)
    jobs.enqueue(run_id)
    with zygote.running(workplace.settings.data) as worker:
        until(lambda: is_in(workplace, run_id, stage), worker)
        asked_at = time.monotonic()
        jobs.cancel(run_id)
        row = until_over(workplace, run_id, worker)
        assert time.monotonic() - asked_at < 5.0
    assert row.status == RunStatus.CANCELLED
    assert set(row.finished_stages) == set(
        itertools.takewhile(lambda one: one != stage, stages_of(example=False))
    )


def test_resuming_a_cancelled_run_goes_on_with_the_stage_that_was_left(
    workplace: Workplace, jobs: Jobs, zygote: Zygote
) -> None:
    run_id = workplace.make_run(steps=ENDLESS)
    jobs.enqueue(run_id)
    with zygote.running(workplace.settings.data) as worker:
        until(lambda: is_in(workplace, run_id, "imitator"), worker)
        jobs.cancel(run_id)
        until_over(workplace, run_id, worker)
        jobs.resume(run_id)
        until(lambda: workplace.run(run_id).epoch == 2, worker)
        until(lambda: is_in(workplace, run_id, "imitator"), worker)
        assert worker.log.read_text().count("stage reward begins") == 1


def put_to_sleep(workplace: Workplace, worker: WorkerProcess) -> None:
    """Stop a worker while it does not write: asleep, it would keep others from writing."""
    while True:
        os.kill(worker.pid, signal.SIGSTOP)
        wait_until(lambda: psutil.Process(worker.pid).status() == psutil.STATUS_STOPPED)
        # Threads stop one after another.
        time.sleep(0.1)
        try:
            with workplace.database.writing() as session:
                session.execute(text("SELECT 1"))
                return
        except OperationalError:
            os.kill(worker.pid, signal.SIGCONT)


def test_a_worker_that_slept_goes_on_with_its_run_which_nobody_took(
    workplace: Workplace, jobs: Jobs, zygote: Zygote
) -> None:
    run_id = workplace.make_run(steps=ENDLESS)
    jobs.enqueue(run_id)

    def names_run() -> bool:
        with workplace.database.reading() as session:
            (status,) = processes.statuses(session)
        return run_id in status.details["runs"]

    watcher = Jobs(workplace.database, workplace.settings, lost_after_s=1.0)
    with closing(watcher), zygote.running(workplace.settings.data) as sleeper:
        until(lambda: is_in(workplace, run_id, "imitator") and names_run(), sleeper)
        put_to_sleep(workplace, sleeper)
        watcher.reconcile()
        asleep_from = time.monotonic()
        while time.monotonic() < asleep_from + 3.0:
            watcher.reconcile()
        assert workplace.run(run_id).epoch == 1
        heartbeat_at = workplace.run(run_id).heartbeat_at
        os.kill(sleeper.pid, signal.SIGCONT)
        until(lambda: workplace.run(run_id).heartbeat_at != heartbeat_at, sleeper)
        assert workplace.run(run_id).epoch == 1
        assert sleeper.log.read_text().count("stage imitator begins") == 1


def test_a_worker_elsewhere_that_slept_finds_its_run_taken_and_leaves_it_and_its_job(
    workplace: Workplace, jobs: Jobs, zygote: Zygote
) -> None:
    run_id = workplace.make_run(steps=ENDLESS)
    jobs.enqueue(run_id)
    data = workplace.settings.data
    with zygote.running(data) as sleeper:
        until(lambda: is_in(workplace, run_id, "imitator"), sleeper)
        put_to_sleep(workplace, sleeper)
        with workplace.database.writing() as session:
            session.execute(update(ProcessRow).values(machine="another"))
        with zygote.running(data, lost_after_s=SOON_S) as other:
            # Until it is leased the run waits in the queue, from which anybody may take it.
            until(lambda: workplace.run(run_id).worker.startswith("worker-1"), other)
            os.kill(sleeper.pid, signal.SIGCONT)
            until(lambda: LEASE_LOST in sleeper.log.read_text(), sleeper)
            until(lambda: "this execution ends" in sleeper.log.read_text(), sleeper)
            until(lambda: is_in(workplace, run_id, "imitator"), other)
            assert workplace.run(run_id).worker.startswith("worker-1")
            assert "Traceback" not in sleeper.log.read_text()


def test_a_worker_that_is_told_to_stop_gives_its_run_back_and_the_next_goes_on(
    workplace: Workplace, jobs: Jobs, zygote: Zygote
) -> None:
    run_id = workplace.make_run(steps=ENDLESS)
    jobs.enqueue(run_id)
    with zygote.running(workplace.settings.data) as worker:
        until(lambda: is_in(workplace, run_id, "imitator"), worker)
        asked_at = time.monotonic()
        worker.send(signal.SIGTERM)
        assert time.monotonic() - asked_at < 10.0
        row = workplace.run(run_id)
        assert row.status == RunStatus.QUEUED
        with workplace.database.reading() as session:
            assert not processes.is_kind_alive(session, "worker")
    with zygote.running(workplace.settings.data) as worker:
        until(lambda: workplace.run(run_id).epoch > row.epoch, worker)
        until(lambda: is_in(workplace, run_id, "imitator"), worker)


def is_copied(store: ArtifactStore, run_id: str) -> bool:
    """Whether the imitator's checkpoint was copied; copies made before are of other stages."""
    if not store.names(f"checkpoints/{run_id}"):
        return False
    with tarfile.open(fileobj=io.BytesIO(store.get(f"checkpoints/{run_id}/1.tar"))) as copy:
        return "imitator/checkpoint.safetensors" in copy.getnames()


@pytest.mark.lengthy
@pytest.mark.parametrize("ending", [signal.SIGKILL, signal.SIGTERM])
def test_a_worker_with_another_data_folder_goes_on_from_the_last_checkpoint(
    workplace: Workplace, jobs: Jobs, zygote: Zygote, tmp_path: Path, ending: signal.Signals
) -> None:
    recipe = with_values(TINY, {"policy.snapshot_steps": (64,)})
    run_id = workplace.make_run(recipe, steps=ENDLESS)
    jobs.enqueue(run_id)
    shared: dict[str, Any] = {
        "database_url": workplace.settings.application_url,
        "jobs_database_url": workplace.settings.queue_url,
        "artifacts_url": str(tmp_path / "shared"),
    }
    store = ArtifactStore(shared["artifacts_url"])
    saved = f"{workplace.settings.data}/runs/{run_id}/1/imitator/checkpoint.safetensors"

    def points() -> list[int]:
        with workplace.database.reading() as session:
            query = select(MetricRow.id).order_by(MetricRow.id)
            return list(
                session.scalars(
                    query.where(MetricRow.run_id == run_id, MetricRow.stage == "imitator")
                )
            )

    with zygote.running(workplace.settings.data, LOST_AFTER_S, **shared) as worker:
        until(Path(saved).exists, worker)
        if ending is signal.SIGKILL:
            until(lambda: is_copied(store, run_id), worker)
        worker.send(ending)
    before = points()
    (tmp_path / "other").mkdir()
    with zygote.running(tmp_path / "other", lost_after_s=SOON_S, **shared) as other:
        until(lambda: points()[-1:] > before[-1:], other)
        assert "goes on from the checkpoints of another machine" in other.log.read_text()
    # A stage that begins anew drops its points; these are still the first worker's.
    assert points()[0] == before[0]
    assert store.names(f"checkpoints/{run_id}") == ["1.tar"]


@pytest.mark.lengthy
def test_a_run_on_s3_whose_worker_is_killed_is_finished_on_another_machine(
    workplace: Workplace, jobs: Jobs, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    url = f"{s3.use(monkeypatch).new_bucket()}/lab"
    recipe = with_values(TINY, {"policy.snapshot_steps": (64,)})
    run_id = workplace.make_run(recipe, steps=ENDLESS)
    jobs.enqueue(run_id)
    store = ArtifactStore(url)
    shared: dict[str, Any] = {
        "database_url": workplace.settings.application_url,
        "jobs_database_url": workplace.settings.queue_url,
        "artifacts_url": url,
    }

    # Forked from a process that has the credentials.
    with closing(Zygote()) as zygote:
        with zygote.running(workplace.settings.data, LOST_AFTER_S, **shared) as worker:
            until(lambda: is_copied(store, run_id), worker)
            worker.kill()
        with workplace.database.writing() as session:
            _, curves = metrics.series(session, run_id)
            reached = int(curves["imitator"]["entropy"][-1][0])
            runs.get(session, run_id).steps = reached + 64
        (tmp_path / "other").mkdir()
        with zygote.running(tmp_path / "other", lost_after_s=SOON_S, **shared) as other:
            row = until_over(workplace, run_id, other)
            assert row.status == RunStatus.DONE, other.log.read_text()
            until(lambda: not store.names(f"checkpoints/{run_id}"), other)
            assert "goes on from the checkpoints of another machine" in other.log.read_text()
    with workplace.database.reading() as session:
        _, curves = metrics.series(session, run_id)
        steps = [int(step) for step, _ in curves["imitator"]["entropy"]]
        files = artifacts.listing(session, run_id)
    # A stage that begins anew drops its points; a run that goes on has each step once.
    assert steps == sorted(set(steps))
    assert steps[-1] == reached + 64
    assert {"reward_model", "imitator", "clone", "attention_map"} <= {file.kind for file in files}
    assert all(len(store.get(file.path)) == file.size_bytes for file in files)


def test_two_workers_never_take_the_same_run(
    workplace: Workplace, jobs: Jobs, zygote: Zygote
) -> None:
    runs = [workplace.make_run(CONFUSED, training_seed=WRONG, go_on_anyway=False) for _ in range(8)]
    for run_id in runs:
        jobs.enqueue(run_id)
    data = workplace.settings.data
    with zygote.running(data) as first, zygote.running(data) as second:
        rows = [until_over(workplace, run_id, first) for run_id in runs]
        assert second.is_alive
    assert [row.status for row in rows] == [RunStatus.STOPPED] * 8
    # Every run was leased exactly once, and both workers had some.
    assert [row.epoch for row in rows] == [1] * 8
    assert len({row.worker for row in rows}) == 2


@pytest.mark.lengthy
def test_runs_for_a_gpu_wait_for_a_worker_that_has_one_which_takes_one_run_at_a_time(
    workplace: Workplace, jobs: Jobs, zygote: Zygote
) -> None:
    def make(device: RunDevice) -> str:
        run_id = workplace.make_run(
            CONFUSED, training_seed=WRONG, go_on_anyway=False, device=device
        )
        jobs.enqueue(run_id)
        return run_id

    for_gpu = [make(RunDevice.GPU) for _ in range(2)]
    first = make(RunDevice.ANY)
    with zygote.running(workplace.settings.data) as worker:
        until_over(workplace, first, worker)
        with workplace.database.reading() as session:
            (status,) = processes.statuses(session)
            assert not processes.is_gpu_worker_alive(session)
        assert (status.details["gpu"], status.details["cores"]) == (None, core_count())
        worker.send(signal.SIGTERM)
    assert {workplace.run(run_id).status for run_id in for_gpu} == {RunStatus.QUEUED}

    everything = [*for_gpu, *(make(RunDevice.ANY) for _ in range(2))]
    command = [sys.executable, "-m", "tests.trainer.runtime.gpu_worker"]
    log = workplace.settings.data / "gpu-worker.log"
    with (
        log.open("w") as output,
        subprocess.Popen([*command, str(workplace.settings.data)], stdout=output) as process,
    ):
        try:
            until(lambda: process.poll() is not None)
        finally:
            process.kill()
    assert process.returncode == 0
    # It asks both queues at once by chance only, and does not go on asking for what it left.
    assert log.read_text().count(LEFT) <= len(everything)
    rows = [workplace.run(run_id) for run_id in everything]
    assert {(row.status, row.epoch) for row in rows} == {(RunStatus.STOPPED, 1)}
    times = sorted((row.started_at, row.finished_at) for row in rows)
    for (_, ended), (begun, _) in itertools.pairwise(times):
        assert ended is not None
        assert begun is not None
        assert ended <= begun


def test_a_ranking_that_is_not_understood_stops_the_run_before_ppo_until_told_to_go_on(
    workplace: Workplace, jobs: Jobs, zygote: Zygote
) -> None:
    run_id = workplace.make_run(CONFUSED, training_seed=WRONG, go_on_anyway=False)
    jobs.enqueue(run_id)
    with zygote.running(workplace.settings.data) as worker:
        row = until_over(workplace, run_id, worker)
        assert row.status == RunStatus.STOPPED
        assert "tau" in row.message
        assert "other demonstrations or another order" in row.message
        assert row.outcome.check is not None
        assert not row.outcome.check.passed
        with workplace.database.reading() as session:
            _, curves = metrics.series(session, run_id)
        assert {"loss", "accuracy"} <= set(curves["reward"])
        assert "clone" not in row.finished_stages
        jobs.resume(run_id)
        until(lambda: "clone" in workplace.run(run_id).finished_stages, worker)


def test_a_failure_is_explained_and_the_worker_lives_on(
    workplace: Workplace, jobs: Jobs, zygote: Zygote
) -> None:
    broken = workplace.make_run()
    with workplace.database.writing() as session:
        recording = recordings.get(session, workplace.ranked[1])
        recording.hashes = ["0" * 16, *recording.hashes[1:]]
    jobs.enqueue(broken)
    with zygote.running(workplace.settings.data) as worker:
        row = until_over(workplace, broken, worker)
        assert row.status == RunStatus.FAILED
        assert f"Recording {workplace.ranked[1]}" in row.message
        log = workplace.settings.data / "logs" / "runs" / f"{broken}.log"
        assert "Traceback" in log.read_text()
        assert worker.is_alive


@pytest.mark.parametrize("n_workers", [2])
def test_workers_of_one_data_folder_have_names_of_their_own(
    workplace: Workplace, zygote: Zygote, n_workers: int
) -> None:
    def names() -> set[str]:
        with workplace.database.reading() as session:
            return {one.name for one in processes.statuses(session) if one.kind == "worker"}

    workers = [zygote.start(workplace.settings.data) for _ in range(n_workers)]
    until(lambda: len(names()) == n_workers, workers[0])
    found = names()
    for worker in workers:
        worker.kill()
    # A number is free again however its worker ended.
    with zygote.running(workplace.settings.data) as again:
        until(lambda: "waits for runs" in again.log.read_text(), again)
        assert names() == found
    assert {name.rpartition("-")[0] for name in found} == {"worker-0", "worker-1"}
