"""Checkpoints and their copies, by which a run goes on on another machine."""

from __future__ import annotations

from pathlib import Path

import pytest

from testsupport.waiting import wait_until
from trainer.runtime import scratch
from trainer.runtime.scratch import CheckpointCopies, fetch_newer_copy, own_scratch_folder
from tril.files.artifact_store import ArtifactStore

RUN = "run"


@pytest.fixture
def store(tmp_path: Path) -> ArtifactStore:
    return ArtifactStore(str(tmp_path / "shared"))


def save(folder: Path, name: str, text: str) -> None:
    path = folder / name
    path.parent.mkdir(exist_ok=True)
    path.write_text(text)


def fetched(store: ArtifactStore, root: Path, epoch: int) -> dict[str, str]:
    """Take the run over on a machine, and return the checkpoints that it goes on from."""
    fetch_newer_copy(store, RUN, root)
    own = own_scratch_folder(root, epoch)
    return {str(path.relative_to(own)): path.read_text() for path in own.glob("*/*")}


def test_another_machine_gets_the_checkpoints_of_the_stages_at_work(
    store: ArtifactStore, tmp_path: Path
) -> None:
    folder = own_scratch_folder(tmp_path / "a", 1)
    save(folder, "reward/network", "finished")
    save(folder, "imitator/checkpoint", "first")
    save(folder, "imitator/.checkpoint-x1", "half written")
    CheckpointCopies(store, RUN, folder, lambda: {"reward"}).copy()
    assert fetched(store, tmp_path / "b", 3) == {"imitator/checkpoint": "first"}


def test_the_newest_lease_counts_wherever_it_was(store: ArtifactStore, tmp_path: Path) -> None:
    here = own_scratch_folder(tmp_path / "a", 1)
    save(here, "imitator/checkpoint", "first")
    CheckpointCopies(store, RUN, here, set).copy()
    save(here, "imitator/checkpoint", "later")
    # The same machine goes on from its own, which is newer than its copy.
    assert fetched(store, tmp_path / "a", 2) == {"imitator/checkpoint": "later"}

    assert fetched(store, tmp_path / "b", 3) == {"imitator/checkpoint": "first"}
    there = own_scratch_folder(tmp_path / "b", 3)
    save(there, "imitator/checkpoint", "there")
    CheckpointCopies(store, RUN, there, set).copy()
    assert store.names(f"checkpoints/{RUN}") == ["3.tar"]
    assert fetched(store, tmp_path / "a", 4) == {"imitator/checkpoint": "there"}


def test_a_worker_that_has_lost_its_run_replaces_no_newer_copy(
    store: ArtifactStore, tmp_path: Path
) -> None:
    lost, present = (own_scratch_folder(tmp_path / name, n) for name, n in (("a", 1), ("b", 2)))
    for folder, text in ((present, "present"), (lost, "lost")):
        save(folder, "imitator/checkpoint", text)
        CheckpointCopies(store, RUN, folder, set).copy()
    assert fetched(store, tmp_path / "c", 3) == {"imitator/checkpoint": "present"}


def test_files_that_change_while_they_are_copied_are_copied_again(
    store: ArtifactStore, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = own_scratch_folder(tmp_path / "a", 1)
    save(folder, "imitator/best", "1")
    save(folder, "imitator/checkpoint", "1")
    archive, versions = CheckpointCopies._archive, iter(["22", "333"])

    def changing(self: CheckpointCopies, files: dict[str, tuple[int, int]]) -> bytes | None:
        content = archive(self, files)
        if (version := next(versions, None)) is not None:
            save(folder, "imitator/best", version)
        return content

    monkeypatch.setattr(CheckpointCopies, "_archive", changing)
    CheckpointCopies(store, RUN, folder, set).copy()
    assert fetched(store, tmp_path / "b", 2)["imitator/best"] == "333"


def test_changed_checkpoints_are_copied_by_themselves_and_others_not(
    store: ArtifactStore, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = own_scratch_folder(tmp_path / "a", 1)
    written: list[str] = []
    put = ArtifactStore.put

    def counted(self: ArtifactStore, path: str, content: bytes) -> int:
        written.append(path)
        return put(self, path, content)

    monkeypatch.setattr(ArtifactStore, "put", counted)
    with CheckpointCopies(store, RUN, folder, set, every_s=0.01) as copies:
        for number, text in enumerate(("one", "three"), start=1):
            save(folder, "imitator/checkpoint", text)
            wait_until(lambda count=number: len(written) == count)  # type: ignore[misc]
        copies.copy()
    assert len(written) == 2
    assert fetched(store, tmp_path / "b", 2) == {"imitator/checkpoint": "three"}


def test_what_is_too_large_and_a_store_that_fails_stop_no_training(
    store: ArtifactStore,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    caplog: pytest.LogCaptureFixture,
) -> None:
    folder = own_scratch_folder(tmp_path / "a", 1)
    save(folder, "imitator/checkpoint", "12345")
    monkeypatch.setattr(scratch, "MAX_COPY_BYTES", 4)
    CheckpointCopies(store, RUN, folder, set).copy()
    assert "too large" in caplog.text
    monkeypatch.undo()
    (tmp_path / "shared").write_text("no folder")
    CheckpointCopies(store, RUN, folder, set).copy()
    assert "could not be copied" in caplog.text
    (tmp_path / "shared").unlink()
    assert fetched(store, tmp_path / "b", 2) == {}
