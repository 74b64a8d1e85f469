"""Files derived from recordings, as far as time allows."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from server.play.replays import ReplayProcess, ReplayTask
from server.replay_cache import ReplayCache
from tests.server.clients import stored
from testsupport.workplace import Workplace
from tril.files.cache import Cache

TASK = ReplayTask.FINAL_PICTURE


@pytest.fixture(scope="module")
def replays() -> Iterator[ReplayProcess]:
    replays = ReplayProcess()
    yield replays
    replays.stop()


@pytest.mark.parametrize("limit_bytes", [0, 10**6])
def test_asking_again_gets_on_whether_or_not_files_can_be_cached(
    workplace: Workplace, replays: ReplayProcess, tmp_path: Path, limit_bytes: int
) -> None:
    recordings = {key: stored(workplace.database, key) for key in workplace.ranked}
    cache = ReplayCache(Cache(tmp_path / "cache", limit_bytes), replays)
    counts = [len(cache.get_within(0.0, recordings, TASK)) for _ in range(5)]
    assert counts == [1, 2, 3, 4, 4]
    assert list(cache.get_within(0.0, recordings, TASK)) == list(recordings)
    made = cache.get_within(0.0, recordings, TASK)
    assert made == {key: cache.get(one, TASK) for key, one in recordings.items()}


def test_what_another_process_has_cached_takes_no_replay(
    workplace: Workplace, replays: ReplayProcess, tmp_path: Path
) -> None:
    recordings = {key: stored(workplace.database, key) for key in workplace.ranked}
    made = ReplayCache(Cache(tmp_path, 10**6), replays).get_within(60.0, recordings, TASK)
    assert made.keys() == recordings.keys()
    again = ReplayCache(Cache(tmp_path, 10**6), replays).get_within(0.0, recordings, TASK)
    assert again == made
