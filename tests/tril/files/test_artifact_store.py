"""The artifact store on a disk, in memory and on an S3 server."""

from __future__ import annotations

import errno
import os
import threading
from pathlib import Path

import pytest

from testsupport import s3
from tril.errors import Invalid, NotFound, Unavailable
from tril.files.artifact_store import ArtifactStore, write_whole


@pytest.fixture(params=["folder", "memory", "s3"])
def store(
    request: pytest.FixtureRequest, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> ArtifactStore:
    if request.param == "folder":
        return ArtifactStore(str(tmp_path))
    if request.param == "memory":
        return ArtifactStore(f"memory://{tmp_path.name}")
    return ArtifactStore(f"{s3.use(monkeypatch).new_bucket()}/some/prefix")


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


def test_folders_are_listed_and_removed_alone_and_more_than_once(store: ArtifactStore) -> None:
    store.put("runs/a/x", b"1")
    store.put("runs/a/deep/y", b"2")
    store.put("runs/ab/x", b"3")
    assert store.names("runs") == ["a", "ab"]
    assert store.names("runs/a") == ["deep", "x"]
    assert store.names("none") == []
    assert not store.exists("runs/a")
    for _ in range(2):
        store.remove_folder("runs/a")
        store.remove("runs/a/x")
        assert store.names("runs") == ["ab"]
    assert store.get("runs/ab/x") == b"3"


def test_a_check_leaves_nothing_behind(store: ArtifactStore) -> None:
    store.put("workers/key", b"1")
    store.check("one")
    assert store.names("workers") == ["key"]


def test_more_files_are_listed_than_an_object_store_tells_at_once(store: ArtifactStore) -> None:
    names = [f"{number:04}" for number in range(1_003)]
    for name in names:
        store.put(f"many/{name}", b"")
    assert store.names("many") == names


def test_readers_see_the_old_file_or_the_new_one_whole(store: ArtifactStore) -> None:
    # Larger than the parts in which object stores are written to.
    contents = [bytes([number]) * 6_000_000 for number in range(3)]
    store.put("x", contents[0])
    writer = threading.Thread(target=lambda: [store.put("x", content) for content in contents * 2])
    writer.start()
    seen = 0
    while writer.is_alive() or not seen:
        assert store.get("x") in contents
        seen += 1
    writer.join()
    assert store.get("x") == contents[-1]


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
