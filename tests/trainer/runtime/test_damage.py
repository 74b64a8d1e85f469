"""Bytes that change on the disk: what was made of them is made again, and the run says so."""

from __future__ import annotations

import random
import threading
from pathlib import Path

import pytest
import torch
from safetensors import SafetensorError

from testsupport.workplace import TINY, Workplace
from trainer.nn.checkpoints import load_tensors, save_tensors
from trainer.runtime.pipeline import GIVEN_BACK, Pipeline
from trainer.runtime.scratch import scratch_folder
from tril.files.artifact_store import ArtifactStore
from tril.files.cache import Cache
from tril.recipes import with_values
from tril.stages import Stage
from tril.store.models import RunRow, RunStatus
from tril.store.training import artifacts
from tril.store.training.artifacts import ArtifactDamaged

QUICK = with_values(TINY, {"policy.snapshot_steps": (64, 128)})


def flip(path: Path, seed: int = 0, count: int = 64) -> None:
    content = bytearray(path.read_bytes())
    for place in random.Random(seed).sample(range(len(content) // 2, len(content)), count):
        content[place] ^= 0x10
    path.write_bytes(content)


@pytest.mark.parametrize("seed", range(8))
def test_a_flipped_bit_of_a_checkpoint_is_noticed(tmp_path: Path, seed: int) -> None:
    path = tmp_path / "x.safetensors"
    tensors = {"a": torch.arange(2000.0), "b": torch.zeros(3, dtype=torch.bfloat16)}
    save_tensors(path, tensors, {"state": '{"steps": 12345}', "format": "x"})
    found, metadata = load_tensors(path)
    assert found.keys() == tensors.keys()
    assert torch.equal(found["a"], tensors["a"])
    assert metadata == {"state": '{"steps": 12345}', "format": "x"}
    flip(path, seed, 1)
    with pytest.raises(SafetensorError, match="damaged"):
        load_tensors(path)


def test_a_changed_text_of_a_checkpoint_is_noticed(tmp_path: Path) -> None:
    path = tmp_path / "x.safetensors"
    save_tensors(path, {"a": torch.zeros(3)}, {"state": '{"steps": 12345}'})
    path.write_bytes(path.read_bytes().replace(b"12345", b"12344"))
    with pytest.raises(SafetensorError, match="damaged"):
        load_tensors(path)


@pytest.fixture
def pipeline(workplace: Workplace) -> Pipeline:
    return Pipeline(workplace.database, workplace.settings, "worker-0", threading.Event())


def leave_before(pipeline: Pipeline, run_id: str, stage: Stage) -> None:
    def run_stage(run_id: str, name: str) -> str:
        return "left" if name == stage else pipeline.run_stage(run_id, name)

    assert pipeline.train(run_id, run_stage) == "left"


def file_of(workplace: Workplace, run_id: str, kind: str) -> Path:
    with workplace.database.reading() as session:
        row = artifacts.of_kind(session, run_id, kind)
    return Path(workplace.settings.artifact_root) / row.path


@pytest.mark.parametrize(
    ("kind", "read_by", "made_by"),
    [
        ("reward_model", Stage.CLONE, Stage.REWARD),
        ("clone", Stage.IMITATOR, Stage.CLONE),
        ("imitator", Stage.EVALUATION, Stage.IMITATOR),
    ],
)
@pytest.mark.parametrize("damage", ["flipped", "truncated, without a digest"])
def test_the_stage_that_made_a_damaged_file_is_done_again(
    workplace: Workplace,
    pipeline: Pipeline,
    kind: str,
    read_by: Stage,
    made_by: Stage,
    damage: str,
) -> None:
    if damage.endswith("digest") and kind == "clone":
        pytest.skip("its zip's checksums are looked at where the warm start is")
    run_id = workplace.make_run(QUICK, steps=64)
    leave_before(pipeline, run_id, read_by)
    path = file_of(workplace, run_id, kind)
    good = path.read_bytes()
    if damage == "flipped":
        flip(path)
    else:
        path.write_bytes(good[:1000])
    if damage.endswith("digest"):
        with workplace.database.writing() as session:
            artifacts.of_kind(session, run_id, kind).sha256 = None
    assert pipeline.train(run_id, pipeline.run_stage) == GIVEN_BACK
    row = workplace.run(run_id)
    assert row.status == RunStatus.QUEUED
    assert "was damaged after it had been written" in row.message
    assert f"The stage “{made_by.label}” is done again." in row.message
    assert made_by not in row.finished_stages
    assert (workplace.settings.data / "logs" / "runs" / f"{run_id}.log").exists()

    leave_before(pipeline, run_id, read_by)
    # A zip of Stable-Baselines3 names the second at which it learned, so that its length varies.
    with workplace.database.reading() as session:
        kept = artifacts.of_kind(session, run_id, kind).sha256
    assert artifacts.digest(path.read_bytes()) == kept
    assert made_by in workplace.run(run_id).finished_stages


@pytest.mark.parametrize("name", ["checkpoint.safetensors", "best.zip"])
def test_an_imitator_begins_anew_if_its_checkpoint_is_damaged(
    workplace: Workplace, pipeline: Pipeline, name: str
) -> None:
    run_id = workplace.make_run(QUICK, steps=64)
    leave_before(pipeline, run_id, Stage.EVALUATION)
    (path,) = scratch_folder(workplace.settings, run_id).glob(f"*/imitator/{name}")
    flip(path)
    with workplace.database.writing() as session:
        row = session.get(RunRow, run_id)
        assert row is not None
        stages = dict(row.finished_stages)
        del stages[Stage.IMITATOR]
        row.finished_stages = stages
    assert pipeline.train(run_id, pipeline.run_stage) == GIVEN_BACK
    message = workplace.run(run_id).message
    assert "checkpoint" in message
    assert "The stage “Imitator” is done again." in message
    leave_before(pipeline, run_id, Stage.EVALUATION)
    assert Stage.IMITATOR in workplace.run(run_id).finished_stages


def test_a_reward_begins_anew_if_its_checkpoint_is_damaged(
    workplace: Workplace, pipeline: Pipeline
) -> None:
    paper = with_values(QUICK, {"reward.method": "paper"})
    run_id = workplace.make_run(paper, steps=64)
    leave_before(pipeline, run_id, Stage.CHECK)
    (checkpoint,) = scratch_folder(workplace.settings, run_id).glob("*/reward/network.safetensors")
    path = file_of(workplace, run_id, "reward_model")
    good = path.read_bytes()
    flip(path)
    flip(checkpoint)
    assert pipeline.train(run_id, pipeline.run_stage) == GIVEN_BACK
    assert pipeline.train(run_id, pipeline.run_stage) == GIVEN_BACK
    leave_before(pipeline, run_id, Stage.CHECK)
    assert len(path.read_bytes()) == len(good)


def test_a_damaged_file_is_not_passed_on(workplace: Workplace) -> None:
    run_id = workplace.make_run()
    store = ArtifactStore(workplace.settings.artifact_root)
    place = artifacts.path_of(run_id, "x.png")
    store.put(place, b"picture")
    with workplace.database.writing() as session:
        row = artifacts.save(
            session, run_id, "figure", "x.png", "image/png", 7, None, artifacts.digest(b"picture")
        )
        old = artifacts.save(session, run_id, "figure", "old.png", "image/png", 7)
    store.put(artifacts.path_of(run_id, "old.png"), b"picture")
    assert artifacts.read(store, row) == artifacts.read(store, old) == b"picture"
    store.put(place, b"Picture")
    with pytest.raises(ArtifactDamaged, match="figure"):
        artifacts.read(store, row)


def test_a_damaged_cached_file_is_derived_again(tmp_path: Path) -> None:
    cache = Cache(tmp_path, 10_000)
    assert cache.get("x", lambda: b"content" * 100) == b"content" * 100
    assert cache.find("x") == b"content" * 100
    flip(tmp_path / "x")
    assert cache.find("x") is None
    assert cache.get("x", lambda: b"content" * 100) == b"content" * 100
    assert cache.find("x") == b"content" * 100
    (tmp_path / "y").write_bytes(b"of an earlier version")
    assert cache.find("y") is None
