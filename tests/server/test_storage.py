"""Disk usage by purpose."""

from __future__ import annotations

from pathlib import Path

import pytest
from starlette.testclient import TestClient

from server.storage import StorageMeter, StorageUse, measure
from testsupport.databases import on_postgresql
from testsupport.workplace import Workplace
from tril.files.cache import sealed
from tril.settings import Settings


def fill(folder: Path) -> Settings:
    for name, size in [
        ("tril.sqlite", 1),
        ("tril.sqlite-wal", 10),
        ("jobs.sqlite", 100),
        ("artifacts/runs/a/model.sqlite", 1_000),
        ("cache/x.frames", 10_000),
        ("secrets.json", 100_000),
    ]:
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes(b"x" * size)
    return Settings(data=folder)


def test_files_are_counted_by_what_they_are_for(tmp_path: Path) -> None:
    use = measure(fill(tmp_path))
    assert use == StorageUse(111, 1_000, 10_000, 100_000)
    assert use.total_bytes == 111_111


def test_an_answer_is_kept_for_a_while(tmp_path: Path) -> None:
    settings = fill(tmp_path)
    patient, eager = StorageMeter(settings, every_s=3600), StorageMeter(settings, every_s=-1)
    assert patient.use() == eager.use()
    (tmp_path / "cache" / "y.frames").write_bytes(b"x")
    assert patient.use().cache_bytes == 10_000
    assert eager.use().cache_bytes == 10_001


@pytest.mark.parametrize("what", ["strip_url", "frames_url"])
def test_the_page_is_told_what_the_cache_takes_and_may_take(
    client: TestClient, workplace: Workplace, what: str
) -> None:
    shown = client.get(f"/api/recordings/{workplace.ranked[0]}").json()
    made = client.get(shown[what]).content
    storage = client.get("/api/system").json()["storage"]
    assert storage["cache_bytes"] == len(sealed(made))
    assert storage["cache_limit_bytes"] == workplace.settings.cache_limit_bytes
    # Those in the data folder, which are SQLite's.
    assert (storage["databases_bytes"] > 10_000) is not on_postgresql()


@pytest.mark.skipif(on_postgresql(), reason="about SQLite's files")
def test_a_page_is_told_that_the_data_folder_is_gone_and_nothing_was_saved(
    client: TestClient, workplace: Workplace, tmp_path: Path
) -> None:
    data = workplace.settings.data
    assert client.patch("/api/player", json={"name": "Ada"}).status_code == 200
    data.rename(tmp_path / "away")
    refused = client.patch("/api/player", json={"name": "Ben"})
    assert refused.status_code == 503
    assert "Put it back" in refused.json()["detail"]
    assert client.get("/api/system").status_code == 503
    (tmp_path / "away").rename(data)
    assert client.get("/api/player").json()["name"] == "Ada"
