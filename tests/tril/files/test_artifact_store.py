"""The artifact store on a disk and behind fsspec."""

from __future__ import annotations

import errno
import os
from pathlib import Path

import pytest

from tril.errors import Invalid, NotFound, Unavailable
from tril.files.artifact_store import ArtifactStore, write_whole


@pytest.fixture(params=["folder", "memory"])
def store(request: pytest.FixtureRequest, tmp_path: Path) -> ArtifactStore:
    root = str(tmp_path) if request.param == "folder" else f"memory://{tmp_path.name}"
    return ArtifactStore(root)


def test_files_are_written_read_and_replaced(store: ArtifactStore) -> None:
    assert store.put("runs/a/model.bin", b"one") == 3
    assert store.get("runs/a/model.bin") == b"one"
    store.put("runs/a/model.bin", b"second")
    with store.local("runs/a/model.bin") as path:
        assert path.name == "model.bin"
        assert path.read_bytes() == b"second"
    assert store.exists("runs/a/model.bin")
    store.remove_folder("runs/a")
    assert not store.exists("runs/a/model.bin")


def test_a_missing_file_is_named(store: ArtifactStore) -> None:
    with pytest.raises(NotFound, match=r"runs/b/x\.png"):
        store.get("runs/b/x.png")
    with pytest.raises(NotFound, match=r"runs/b/x\.png"), store.local("runs/b/x.png"):
        pass


@pytest.mark.parametrize("path", ["../secret", "/etc/passwd", "runs/../../x", "", "a\\b", "a\0b"])
def test_no_path_leads_out_of_the_store(store: ArtifactStore, path: str) -> None:
    with pytest.raises(Invalid):
        store.put(path, b"")
    with pytest.raises(Invalid):
        store.get(path)


def test_a_write_that_fails_leaves_the_old_file_and_nothing_else(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    store = ArtifactStore(str(tmp_path))
    store.put("runs/a/x", b"old")

    def full(_descriptor: int) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(Unavailable, match="disk is full"):
        store.put("runs/a/x", b"new")
    monkeypatch.undo()
    assert store.get("runs/a/x") == b"old"
    assert [path.name for path in (tmp_path / "runs" / "a").iterdir()] == ["x"]


def test_a_secret_file_is_for_its_owner_alone(tmp_path: Path) -> None:
    write_whole(tmp_path / "secret", b"s", mode=0o600)
    assert (tmp_path / "secret").stat().st_mode & 0o777 == 0o600
