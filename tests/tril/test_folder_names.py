"""Data folders whose names would mean something in a URL, a pattern or a configuration file."""

from __future__ import annotations

import os
import shutil
from pathlib import Path

import pytest
from pydantic import ValidationError
from sqlalchemy import make_url

from testsupport.databases import on_postgresql
from tril.exchange.backup import check_backup, make_backup
from tril.files.artifact_store import ArtifactStore
from tril.jobs import Jobs, prepare_queue
from tril.settings import Settings
from tril.store.copies import copy_before_upgrade
from tril.store.database import create_database
from tril.store.schema import check_schema, upgrade

pytestmark = pytest.mark.skipif(on_postgresql(), reason="about SQLite's files")

NAMES = [
    "50%20x",
    "a#b",
    "q?mode=memory&uri=true",
    "with space",
    "ünï – 日本",
    "c:olon",
    "-dash",
    "new\nline",
    "a::b",
    "%(here)s",
    "[glob]*",
    "plus+and@sign",
    "~",
    "file:x",
]


@pytest.mark.parametrize("name", NAMES)
def test_everything_is_in_the_folder_that_is_named(tmp_path: Path, name: str) -> None:
    data = tmp_path / "data" / name
    settings = Settings(data=data)
    database = create_database(settings.application_url)
    upgrade(database)
    prepare_queue(settings)
    Jobs(database, settings).close()
    store = ArtifactStore(settings.artifact_root)
    store.put("runs/a/model.bin", b"weights")
    copy_before_upgrade(database.engine, "0001", settings.upgrade_copies)
    database.close()

    assert [path.name for path in (tmp_path / "data").iterdir()] == [name]
    found = {entry for entry in os.listdir(data) if "-wal" not in entry and "-shm" not in entry}
    assert found == {"tril.sqlite", "jobs.sqlite", "artifacts", "before-upgrades"}
    assert store.names("runs/a") == ["model.bin"]
    assert (data / "artifacts/runs/a/model.bin").read_bytes() == b"weights"

    made = make_backup(settings, tmp_path / "backups" / name)
    assert made.n_files == 3
    assert check_backup(made.folder) == made
    assert os.listdir(tmp_path / "backups") == [name]
    restored = create_database(Settings(data=made.folder).application_url)
    check_schema(restored)
    restored.close()
    store.remove_folder("runs")
    assert not (data / "artifacts/runs").exists()


def test_an_installation_may_have_percent_signs_in_its_path(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = tmp_path / "50%20x %(here)s"
    shutil.copytree(Path(__file__).parents[2] / "migrations", folder)
    monkeypatch.setattr("tril.store.schema._MIGRATIONS", folder)
    database = create_database(Settings(data=tmp_path / "data").application_url)
    upgrade(database)
    check_schema(database)
    database.close()


@pytest.mark.parametrize("data", ["~nobody-of-this-name/x", "circle/x"])
def test_a_folder_that_cannot_be_found_is_a_setting_to_correct(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, data: str
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "circle").symlink_to("circle")
    with pytest.raises(ValidationError, match=r"home directory|loop"):
        Settings(data=Path(data))


def test_a_link_and_a_relative_path_name_the_folder_itself(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "disk%20x").mkdir()
    (tmp_path / "link").symlink_to("disk%20x")
    monkeypatch.chdir(tmp_path)
    url = make_url(Settings(data=Path("link/../link/x")).application_url)
    assert url.database == str(tmp_path / "disk%20x" / "x" / "tril.sqlite")


@pytest.mark.parametrize("scheme", ["", "file://"])
def test_a_backup_has_the_files_of_a_store_in_another_folder(tmp_path: Path, scheme: str) -> None:
    settings = Settings(data=tmp_path / "data", artifacts_url=f"{scheme}{tmp_path / 'sto%20re'}")
    database = create_database(settings.application_url)
    upgrade(database)
    database.close()
    prepare_queue(settings)
    ArtifactStore(settings.artifact_root).put("runs/a/model.bin", b"weights")
    made = make_backup(settings, tmp_path / "backup")
    assert (made.folder / "artifacts/runs/a/model.bin").read_bytes() == b"weights"
