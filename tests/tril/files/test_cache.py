"""The bounded cache of files that can be made again."""

from __future__ import annotations

import os
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from tril.files.cache import Cache


def test_cached_files_are_not_made_again(tmp_path: Path) -> None:
    made = []

    def make() -> bytes:
        made.append(1)
        return b"frames"

    for cache in (Cache(tmp_path, 1000), Cache(tmp_path, 1000)):
        assert cache.get("abc.frames", make) == b"frames"
    assert len(made) == 1


def test_what_is_cached_is_found_without_making_it(tmp_path: Path) -> None:
    cache = Cache(tmp_path, 1000)
    assert cache.find("abc.final") is None
    cache.get("abc.final", lambda: b"picture")
    assert cache.find("abc.final") == b"picture"
    with pytest.raises(ValueError, match="plain file name"):
        cache.find("../abc")


def test_concurrent_callers_make_a_file_once(tmp_path: Path) -> None:
    cache = Cache(tmp_path, 1000)
    barrier = threading.Barrier(6)
    made = []

    def make() -> bytes:
        made.append(1)
        return b"x"

    def ask(_: int) -> bytes:
        barrier.wait()
        return cache.get("a.png", make)

    with ThreadPoolExecutor(6) as threads:
        assert set(threads.map(ask, range(6))) == {b"x"}
    assert len(made) == 1


def test_the_limit_holds_and_the_longest_unused_goes_first(tmp_path: Path) -> None:
    cache = Cache(tmp_path, 1000)
    for number in range(9):
        cache.get(f"{number}.x", lambda: bytes(84))
        os.utime(tmp_path / f"{number}.x", (1000 + number, 1000 + number))
    cache.get("0.x", lambda: pytest.fail("it is there"))
    for number in (9, 10):
        cache.get(f"{number}.x", lambda: bytes(84))
    left = {path.name for path in tmp_path.iterdir()}
    assert sum((tmp_path / name).stat().st_size for name in left) <= 1000
    assert {"0.x", "9.x", "10.x", "8.x"} <= left
    assert "1.x" not in left


def test_files_of_other_processes_count(tmp_path: Path) -> None:
    (tmp_path / "theirs.x").write_bytes(bytes(950))
    os.utime(tmp_path / "theirs.x", (1000, 1000))
    Cache(tmp_path, 1000).get("ours.x", lambda: bytes(100))
    assert [path.name for path in tmp_path.iterdir()] == ["ours.x"]


def test_a_file_larger_than_the_limit_is_returned_uncached(tmp_path: Path) -> None:
    cache = Cache(tmp_path / "cache", 10)
    assert cache.get("a.x", lambda: bytes(11)) == bytes(11)
    assert Cache(tmp_path / "cache", 0).get("a.x", lambda: b"y") == b"y"
    assert not (tmp_path / "cache").exists()


def test_a_file_that_cannot_be_written_is_returned(tmp_path: Path) -> None:
    (tmp_path / "cache").write_text("a file where the folder should be")
    with pytest.raises(NotADirectoryError):
        list((tmp_path / "cache").iterdir())
    assert Cache(tmp_path / "cache", 1000).get("a.x", lambda: b"made") == b"made"


def test_temporary_files_of_killed_processes_are_removed(tmp_path: Path) -> None:
    (tmp_path / ".a.x-tmp").write_bytes(bytes(50))
    (tmp_path / ".b.x-tmp").write_bytes(bytes(50))
    old = time.time() - 3600
    os.utime(tmp_path / ".a.x-tmp", (old, old))
    Cache(tmp_path, 60).get("c.x", lambda: bytes(24))
    assert {path.name for path in tmp_path.iterdir()} == {".b.x-tmp", "c.x"}


@pytest.mark.parametrize("name", ["", "../a", "a/b", ".hidden", "a\0"])
def test_only_plain_names_are_taken(tmp_path: Path, name: str) -> None:
    with pytest.raises(ValueError, match="plain file name"):
        Cache(tmp_path, 100).get(name, lambda: b"")


def test_a_failed_make_leaves_no_file(tmp_path: Path) -> None:
    cache = Cache(tmp_path, 100)

    def fail() -> bytes:
        raise RuntimeError("no")

    with pytest.raises(RuntimeError):
        cache.get("a.x", fail)
    assert cache.get("a.x", lambda: b"now") == b"now"
