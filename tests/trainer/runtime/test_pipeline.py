"""A pipeline's ways around crashes, in this process and without a queue."""

from __future__ import annotations

import errno
import threading
from pathlib import Path

import pytest
import torch

from tests.trainings import checked
from testsupport.space_invaders import evaluation_start
from testsupport.waiting import wait_until
from testsupport.workplace import TINY, Workplace
from trainer.policy.imitation import Snapshot
from trainer.policy.networks import load_network
from trainer.reporting.run_entry import describe_example
from trainer.runtime.pipeline import (
    FINISHED,
    GIVEN_BACK,
    LEASE_LOST,
    LEFT,
    Pipeline,
    RunStage,
    failure_message,
)
from trainer.runtime.run_data import RunData
from trainer.runtime.scratch import own_scratch_folder
from trainer.runtime.stages import STAGE_WORK, demonstrations, learning
from trainer.runtime.stages.evaluation import demonstrated_starts
from trainer.runtime.stages.snapshots import keep_snapshot
from trainer.runtime.worker import sweep_periodically
from tril.analysis.outcome import RunOutcome, RunSnapshot
from tril.demonstrators import PERFECT, example_tasks
from tril.errors import Invalid, Unavailable
from tril.files.artifact_store import ArtifactStore, ArtifactStoreUnavailable
from tril.games.base import Console
from tril.recipes import with_values
from tril.stages import Stage, stages_of
from tril.store import behaviours, borrowed, rankings, recordings
from tril.store.models import RunStatus, Source
from tril.store.training import artifacts, leases, runs, training_games
from tril.teaching.new_run import create_run

NAME = "worker-0"


@pytest.fixture
def pipeline(workplace: Workplace) -> Pipeline:
    return Pipeline(workplace.database, workplace.settings, NAME, threading.Event())


def only(pipeline: Pipeline, *stages: str) -> RunStage:
    """Do these stages and then leave, as if the worker had been killed."""

    def run_stage(run_id: str, stage: str) -> str:
        return pipeline.run_stage(run_id, stage) if stage in stages else "left"

    return run_stage


def test_a_stage_that_the_queue_remembers_and_the_row_does_not_is_done_again(
    workplace: Workplace, pipeline: Pipeline
) -> None:
    run_id = workplace.make_run()
    # The queue's record says of every stage that it is finished.
    assert pipeline.train(run_id, lambda *_: FINISHED) == GIVEN_BACK
    row = workplace.run(run_id)
    assert row.status == RunStatus.QUEUED
    assert row.finished_stages == {}


def test_a_run_that_another_worker_has_is_left_alone(
    workplace: Workplace, pipeline: Pipeline
) -> None:
    run_id = workplace.make_run()
    workplace.lease(run_id, "worker-1")
    assert pipeline.train(run_id, pipeline.run_stage) == "nothing to do"
    assert workplace.run(run_id).worker == "worker-1"


def test_a_stopping_worker_takes_nothing_up(workplace: Workplace) -> None:
    stopping = threading.Event()
    stopping.set()
    pipeline = Pipeline(workplace.database, workplace.settings, NAME, stopping)
    run_id = workplace.make_run()
    assert pipeline.train(run_id, pipeline.run_stage) == "left in the queue"
    assert workplace.run(run_id).epoch == 0


def test_a_crash_between_the_check_and_the_stop_still_stops_the_run(
    workplace: Workplace, pipeline: Pipeline
) -> None:
    run_id = workplace.make_run(go_on_anyway=False)
    lease = workplace.lease(run_id, NAME)
    with workplace.database.writing() as session:
        for stage in ("trajectories", "reward", "check"):
            row = leases.finish_stage(session, lease, stage, 1.0)
        row.outcome = checked({}, passed=False, advice="Confused.")
    assert pipeline.train(run_id, pipeline.run_stage) == RunStatus.STOPPED
    assert workplace.run(run_id).message == "Confused."


@pytest.fixture
def shared(workplace: Workplace, tmp_path: Path) -> Path:
    """Return a shared folder of files that is not mounted, so to say."""
    folder = tmp_path / "shared"
    folder.write_text("")
    return folder


def sharing(workplace: Workplace, shared: Path) -> Pipeline:
    settings = workplace.settings.model_copy(update={"artifacts_url": str(shared)})
    return Pipeline(workplace.database, settings, NAME, threading.Event())


def test_a_run_is_not_taken_up_while_its_store_is_away(workplace: Workplace, shared: Path) -> None:
    run_id = workplace.make_run()
    pipeline = sharing(workplace, shared)
    pipeline.sweep()
    assert pipeline.train(run_id, pipeline.run_stage) == LEFT
    row = workplace.run(run_id)
    assert (row.status, row.epoch) == (RunStatus.QUEUED, 0)
    assert "The artifact store" in row.message
    assert "goes on by itself" in row.message

    shared.unlink()
    assert pipeline.train(run_id, only(pipeline, Stage.TRAJECTORIES)) == "left"
    row = workplace.run(run_id)
    assert (row.message, set(row.finished_stages)) == ("", {Stage.TRAJECTORIES})


def test_a_run_whose_store_goes_away_waits_and_goes_on(workplace: Workplace, shared: Path) -> None:
    run_id = workplace.make_run()
    shared.unlink()
    pipeline = sharing(workplace, shared)

    def run_stage(run_id: str, stage: str) -> str:
        if stage == Stage.REWARD:
            shared.rename(shared.with_name("away"))
            shared.write_text("", encoding="utf-8")
        return pipeline.run_stage(run_id, stage)

    assert pipeline.train(run_id, run_stage) == GIVEN_BACK
    row = workplace.run(run_id)
    assert (row.status, set(row.finished_stages)) == (RunStatus.QUEUED, {Stage.TRAJECTORIES})
    assert "The artifact store" in row.message
    pipeline.sweep()

    shared.unlink()
    shared.with_name("away").rename(shared)
    again = only(pipeline, Stage.TRAJECTORIES, Stage.REWARD)
    assert pipeline.train(run_id, again) == "left"
    assert Stage.REWARD in workplace.run(run_id).finished_stages


def test_a_run_that_is_done_stays_done_although_its_copies_cannot_be_removed(
    workplace: Workplace, shared: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    run_id = workplace.make_run()
    shared.unlink()
    pipeline = sharing(workplace, shared)

    def refuse(_store: ArtifactStore, _path: str) -> None:
        raise ArtifactStoreUnavailable(OSError("refused"))

    lease = workplace.lease(run_id, NAME)
    with workplace.database.writing() as session:
        for stage in stages_of(example=False):
            leases.finish_stage(session, lease, stage, 1.0)
    monkeypatch.setattr(ArtifactStore, "remove_folder", refuse)
    assert pipeline.train(run_id, lambda *_: FINISHED) == RunStatus.DONE
    assert workplace.run(run_id).status == RunStatus.DONE


def test_a_run_that_cannot_be_started_fails_with_a_reason(
    workplace: Workplace, pipeline: Pipeline
) -> None:
    run_id = workplace.make_run()
    with workplace.database.writing() as session:
        runs.get(session, run_id).recipe = {"name": "of another version"}
    assert pipeline.train(run_id, pipeline.run_stage) == RunStatus.FAILED
    assert "not a recipe of this version" in workplace.run(run_id).message


def test_a_run_that_passes_to_another_worker_in_the_middle_is_dropped(
    workplace: Workplace, pipeline: Pipeline
) -> None:
    run_id = workplace.make_run()

    def run_stage(run_id: str, stage: str) -> str:
        if stage == "reward":
            with workplace.database.writing() as session:
                assert leases.revoke(session, run_id, runs.get(session, run_id).epoch)
            workplace.lease(run_id, "worker-1")
        return pipeline.run_stage(run_id, stage)

    assert pipeline.train(run_id, run_stage) == LEASE_LOST
    row = workplace.run(run_id)
    assert (row.status, row.worker) == (RunStatus.RUNNING, "worker-1")
    assert set(row.finished_stages) == {"trajectories"}


def test_each_lease_has_its_own_scratch_folder_with_what_the_last_one_left(tmp_path: Path) -> None:
    first = own_scratch_folder(tmp_path / "run", 1)
    (first / "checkpoint").write_text("at 100")
    second = own_scratch_folder(tmp_path / "run", 3)
    assert (second / "checkpoint").read_text() == "at 100"
    # The worker that had it before can't find the checkpoint any more, let alone replace it.
    assert not first.exists()
    first.mkdir()
    (first / "checkpoint").write_text("of the past")
    third = own_scratch_folder(tmp_path / "run", 4)
    assert (third / "checkpoint").read_text() == "at 100"
    assert [path.name for path in (tmp_path / "run").iterdir()] == ["4"]


def test_scratch_folders_of_runs_that_are_done_or_deleted_are_swept(
    workplace: Workplace, pipeline: Pipeline
) -> None:
    done, deleted, cancelled = (workplace.make_run() for _ in range(3))
    lease = workplace.lease(done, NAME)
    with workplace.database.writing() as session:
        leases.end(session, lease, RunStatus.DONE)
        for run_id in (deleted, cancelled):
            runs.request_cancel(session, run_id)
        runs.delete(session, deleted)
    folders = {
        run_id: workplace.settings.data / "runs" / run_id
        for run_id in (done, deleted, cancelled, "of another database")
    }
    for folder in folders.values():
        (folder / "1").mkdir(parents=True)
    pipeline.sweep()
    left = {run_id for run_id, folder in folders.items() if folder.exists()}
    assert left == {cancelled, "of another database"}


def test_the_folder_of_a_run_that_another_machine_has_finished_goes_while_the_worker_is_idle(
    workplace: Workplace, pipeline: Pipeline
) -> None:
    run_id = workplace.make_run()
    lease = workplace.lease(run_id, "worker-of-another-machine")
    folder = workplace.settings.data / "runs" / run_id
    (folder / "1").mkdir(parents=True)
    stopping = threading.Event()
    sweeping = threading.Thread(target=sweep_periodically, args=(stopping, pipeline, 0.01))
    sweeping.start()
    try:
        with workplace.database.writing() as session:
            assert folder.exists()
            leases.end(session, lease, RunStatus.DONE)
        wait_until(lambda: not folder.exists())
    finally:
        stopping.set()
        sweeping.join()


def test_failures_are_explained_with_what_to_do() -> None:
    full = OSError(errno.ENOSPC, "No space left on device")
    assert "Free some space" in failure_message("imitator", full, "x")
    assert "not enough memory" in failure_message("imitator", MemoryError(), "x")
    assert failure_message("reward", Unavailable("Plain words."), "x") == "Plain words."
    unexpected = failure_message("clone", ZeroDivisionError("division by zero"), "abc")
    assert "ZeroDivisionError: division by zero" in unexpected
    assert "logs/runs/abc.log" in unexpected


def policy_of(workplace: Workplace, run_id: str, kind: str) -> dict[str, torch.Tensor]:
    """Return the weights of a run's imitator or clone."""
    store = ArtifactStore(workplace.settings.artifact_root)
    with artifacts.local_file(workplace.database, store, run_id, kind) as path:
        return load_network(path).state_dict()


def test_a_continued_run_begins_with_its_parents_imitator_and_still_has_a_clone(
    workplace: Workplace, pipeline: Pipeline
) -> None:
    to_the_imitator = only(pipeline, *list(Stage)[: list(Stage).index(Stage.EVALUATION)])
    parent = workplace.make_run(TINY, steps=128)
    assert pipeline.train(parent, to_the_imitator) == "left"
    # So little is learned that the imitator is what it began with.
    frozen = with_values(TINY, {"policy.learning_rate": 1e-12})
    child = workplace.make_run(frozen, steps=64, training_seed=1, parent_run_id=parent)
    # The files of a deleted run stay, so the child does not notice.
    with workplace.database.writing() as session:
        runs.get(session, parent).status = RunStatus.CANCELLED
        runs.delete(session, parent)
    assert pipeline.train(child, to_the_imitator) == "left"
    began_with = policy_of(workplace, child, "imitator")
    for kind, is_start in (("imitator", True), ("clone", False)):
        same = [
            torch.allclose(tensor, began_with[name], rtol=0, atol=1e-9)
            for name, tensor in policy_of(workplace, parent, kind).items()
        ]
        assert all(same) == is_start, kind
    clones = [policy_of(workplace, run_id, "clone") for run_id in (parent, child)]
    assert not all(torch.equal(clones[0][name], clones[1][name]) for name in clones[0])


def test_an_imitator_can_be_seen_ranked_and_continued_while_it_learns(
    workplace: Workplace, pipeline: Pipeline, monkeypatch: pytest.MonkeyPatch
) -> None:
    values = {"policy.snapshot_steps": (64, 128), "policy.snapshot_episodes": 2}
    run_id = workplace.make_run(with_values(TINY, values), steps=192)
    to_the_imitator = only(pipeline, *list(Stage)[: list(Stage).index(Stage.EVALUATION)])
    found = []

    def keep_twice(data: RunData, snapshot: Snapshot, path: Path, console: Console) -> None:
        for _ in range(2):
            keep_snapshot(data, snapshot, path, console)
        with workplace.database.reading() as session:
            details = artifacts.of_kind(session, run_id, "imitator").details
            found.append((details, training_games.latest(session, run_id)))
        if snapshot.steps == 128:
            raise KeyboardInterrupt

    monkeypatch.setattr(learning, "keep_snapshot", keep_twice)
    with pytest.raises(KeyboardInterrupt):
        pipeline.train(run_id, to_the_imitator)
    assert [(details, steps) for details, (steps, _) in found] == [
        ({"steps": 64}, 64),
        ({"steps": 128}, 128),
    ]
    for steps, (_, (_, games)) in zip((64, 128), found, strict=True):
        assert len(games) == 2
        assert {(game.source, game.run_id) for game in games} == {(Source.POLICY, run_id)}
        assert {game.conditions["steps"] for game in games} == {steps}
        assert {game.conditions["sticky_action_probability"] for game in games} == {0.25}
    with workplace.database.writing() as session:
        games = found[-1][1][1]
        borrowed.borrow(session, workplace.behaviour_id, [game.id for game in games])
        child = create_run(session, 1, TINY, 64, 0, parent_run_id=run_id)
        assert child.parent_run_id == run_id


def test_what_a_parent_has_learned_from_is_not_held_out_from_its_children(
    workplace: Workplace, pipeline: Pipeline, monkeypatch: pytest.MonkeyPatch
) -> None:
    with workplace.database.writing() as session:
        recordings.get(session, workplace.ranked[3]).start = evaluation_start(7).to_json()
    of_start_0 = with_values(TINY, {"policy.own_starts": (0,)})
    grandparent, child = workplace.make_run(of_start_0), workplace.make_run()
    with workplace.database.writing() as session:
        rankings.save(session, workplace.behaviour_id, 1, [[n] for n in workplace.ranked[:3]])
    parent, alone = workplace.make_run(), workplace.make_run()
    with workplace.database.writing() as session:
        runs.get(session, parent).parent_run_id = grandparent
        runs.get(session, child).parent_run_id = parent
        runs.request_cancel(session, grandparent)
        runs.delete(session, grandparent)
    seen: list[set[int]] = []
    monkeypatch.setitem(
        STAGE_WORK, Stage.TRAJECTORIES, lambda data, _: seen.append(demonstrated_starts(data))
    )
    for run_id in (child, parent, alone):
        pipeline.train(run_id, only(pipeline, Stage.TRAJECTORIES))
    assert seen == [{0, 7}, {0, 7}, set()]


@pytest.fixture
def few_tasks(monkeypatch: pytest.MonkeyPatch) -> int:
    """Let an example have two demonstrations to rank and a perfect one."""

    def chosen(*arguments: object) -> object:
        tasks = example_tasks(*arguments)  # type: ignore[arg-type]
        return [*tasks[:2], tasks[-1]]

    monkeypatch.setattr(demonstrations, "example_tasks", chosen)
    return 3


def make_example(
    workplace: Workplace, behaviour_id: int, kind: str = "scripted", training_seed: int = 0
) -> str:
    with workplace.database.writing() as session:
        return create_run(
            session, behaviour_id, TINY, 64, training_seed, example=True, example_kind=kind
        ).id


def scripted(workplace: Workplace, behaviour_id: int) -> list[int]:
    with workplace.database.reading() as session:
        rows = recordings.listing(session, behaviour_id)
    return sorted(row.id for row in rows if row.source == Source.SCRIPTED)


def test_an_example_makes_ranks_and_freezes_its_demonstrations_once(
    workplace: Workplace, pipeline: Pipeline, few_tasks: int
) -> None:
    with workplace.database.reading() as session:
        behaviour_id = workplace.behaviour_id + 1
        assert rankings.current(session, behaviour_id).revision == 0
    first = make_example(workplace, behaviour_id)
    assert pipeline.train(first, only(pipeline, Stage.DEMONSTRATIONS)) == "left"
    made = scripted(workplace, behaviour_id)
    assert len(made) == few_tasks
    with workplace.database.reading() as session:
        ranking = rankings.current(session, behaviour_id)
        perfect = recordings.perfect_ids(session, behaviour_id)
    assert (ranking.change, ranking.tiers) == ("example", [[made[0]], [made[1]]])
    assert perfect == [made[2]]
    frozen = RunSnapshot(ranking_revision=1, tiers=ranking.tiers, perfect=perfect)
    assert workplace.run(first).snapshot == frozen
    # One that was deleted is made again, the others are not.
    with workplace.database.writing() as session:
        recordings.delete(session, [recordings.get(session, made[1])], None)
    second = make_example(workplace, behaviour_id)
    pipeline.train(second, only(pipeline, Stage.DEMONSTRATIONS))
    again = scripted(workplace, behaviour_id)
    assert len(again) == few_tasks
    assert len(set(again) & set(made)) == few_tasks - 1
    snapshot = workplace.run(second).snapshot
    assert snapshot is not None
    assert snapshot.tiers == [[made[0]], [again[-1]]]
    # The ranking is somebody's by now: it stays as it is, and the example learns from its own.
    assert snapshot.ranking_revision is None
    assert workplace.run(first).snapshot == frozen


def test_kinds_of_example_keep_apart_from_each_other_and_from_the_library(
    workplace: Workplace, pipeline: Pipeline, monkeypatch: pytest.MonkeyPatch
) -> None:
    def chosen(*arguments: object) -> object:
        tasks = example_tasks(*arguments)  # type: ignore[arg-type]
        # Flawless games take long, and mistakes need all tiers.
        return [*tasks[:2], tasks[-1]] if tasks[0].error_model == PERFECT else tasks

    monkeypatch.setattr(demonstrations, "N_PERFECT", 1)
    monkeypatch.setattr(demonstrations, "example_tasks", chosen)
    behaviour_id = workplace.behaviour_id + 1
    learned_from: dict[str, set[int]] = {}
    for kind, n_ranked in (("human", 12), ("six", 2)):
        run_id = make_example(workplace, behaviour_id, kind)
        assert pipeline.train(run_id, only(pipeline, Stage.DEMONSTRATIONS)) == "left"
        run = workplace.run(run_id)
        assert run.snapshot is not None
        assert len(run.snapshot.ranked) == n_ranked
        assert run.snapshot.ranking_revision is None
        learned_from[kind] = {*run.snapshot.ranked, *run.snapshot.perfect}
        with workplace.database.reading() as session:
            made = recordings.by_ids(session, learned_from[kind]).values()
            assert recordings.listing(session, behaviour_id) == []
            assert recordings.perfect_ids(session, behaviour_id) == []
            assert rankings.current(session, behaviour_id).revision == 0
            assert not behaviours.counts(session, behaviour_id)[behaviour_id].has_example
        assert {(row.source, row.run_id) for row in made} == {(Source.SCRIPTED, run_id)}
        assert [row.perfect for row in made].count(True) == 1
        names = {row.conditions.get("manner", {}).get("name", "perfect") for row in made}
        assert names == {"human" if kind == "human" else "perfect"}
    # The ordinary example finds everything as if there were no other.
    ordinary = make_example(workplace, behaviour_id)
    pipeline.train(ordinary, only(pipeline, Stage.DEMONSTRATIONS))
    learned_from["scripted"] = set(scripted(workplace, behaviour_id))
    assert len(learned_from["scripted"]) == 3
    assert sum(map(len, learned_from.values())) == len(set().union(*learned_from.values()))
    assert workplace.run(ordinary).outcome == RunOutcome()
    with workplace.database.reading() as session:
        assert rankings.current(session, behaviour_id).change == "example"


def test_a_human_example_says_what_order_its_games_should_have_and_is_made_once(
    workplace: Workplace, pipeline: Pipeline, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(demonstrations, "N_PERFECT", 1)
    snapshots, outcomes = [], []
    for training_seed in (0, 1):
        run_id = make_example(workplace, workplace.behaviour_id, "human", training_seed)
        pipeline.train(run_id, only(pipeline, Stage.DEMONSTRATIONS))
        run = workplace.run(run_id)
        snapshots.append(run.snapshot)
        outcomes.append(run.outcome)
    assert snapshots[0] == snapshots[1]
    assert outcomes[0] == outcomes[1]
    example = outcomes[0].example
    assert snapshots[0] is not None
    assert example is not None
    assert example.kind == "human"
    assert example.given_tiers == snapshots[0].tiers != example.true_tiers
    assert len(example.mistakes) == 3
    assert 0.7 < example.tau < 1
    said = describe_example(outcomes[0])
    assert "of the kind \u201chuman\u201d" in said
    assert "3 pairs of neighbours are ranked the wrong way round" in said
    assert describe_example(RunOutcome()) == ""


def test_an_unknown_kind_of_example_is_refused(workplace: Workplace) -> None:
    with pytest.raises(Invalid, match="Unknown demonstrations 'seven'"):
        make_example(workplace, workplace.behaviour_id, "seven")
