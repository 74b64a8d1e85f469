"""Backups while everything is in use."""

from __future__ import annotations

import json
import os
import shutil
import sqlite3
import threading
from collections.abc import Callable
from contextlib import closing
from pathlib import Path

import pytest

from tests.tril.exchange.samples import MODEL, finished_run
from testsupport.databases import on_postgresql
from testsupport.workplace import Workplace, make_workplace
from tril.errors import Conflict, Unavailable
from tril.exchange import backup
from tril.exchange.backup import BackupDamaged, check_backup, make_backup
from tril.files.artifact_store import ArtifactStore
from tril.jobs import Jobs
from tril.recording import verify
from tril.settings import Settings
from tril.store import behaviours, borrowed, rankings, recordings
from tril.store.copies import copy_sqlite
from tril.store.database import create_database
from tril.store.models import RunRow, RunStatus, Source
from tril.store.schema import check_schema
from tril.store.training import artifacts, runs

pytestmark = pytest.mark.skipif(
    on_postgresql(), reason="about SQLite's files; PostgreSQL's are in test_postgresql_backup.py"
)


def test_a_backup_can_be_worked_on_and_has_everything(workplace: Workplace, tmp_path: Path) -> None:
    run_id = finished_run(workplace)
    made = make_backup(workplace.settings, tmp_path / "backup")
    assert (made.n_recordings, made.n_runs, made.n_files, made.notices) == (4, 1, 3, ())
    assert check_backup(tmp_path / "backup") == made
    assert sorted(path.name for path in (tmp_path / "backup").iterdir()) == [
        "artifacts",
        "jobs.sqlite",
        "manifest.json",
        "tril.sqlite",
    ]

    settings = Settings(data=made.folder)
    database = create_database(settings.application_url)
    check_schema(database)
    with database.reading() as session:
        behaviour = behaviours.by_slug(session, "column-1")
        tiers = rankings.current(session, behaviour.id).tiers
        rows = recordings.by_ids(session, workplace.ranked).values()
    assert tiers == [[key] for key in workplace.ranked]
    for row in rows:
        hits = [(hit.row, hit.column) for hit in recordings.taken_of(row)]
        verify(recordings.as_recording(row), hits)
    store = ArtifactStore(settings.artifact_root)
    assert store.get(artifacts.path_of(run_id, "model.bin")) == MODEL
    jobs = Jobs(database, settings)
    jobs.reconcile()
    jobs.close()
    database.close()


def test_a_backup_has_the_ranked_games_and_the_imitator_of_a_deleted_run(
    workplace: Workplace, tmp_path: Path
) -> None:
    parent = finished_run(workplace)
    with workplace.database.writing() as session:
        game = recordings.as_recording(recordings.get(session, workplace.ranked[0]))
        lent = recordings.add(
            session,
            workplace.behaviour_id,
            game,
            verify(game).replay,
            Source.POLICY,
            run_id=parent,
        ).id
        borrowed.borrow(session, workplace.behaviour_id, [lent])
        rankings.save(session, workplace.behaviour_id, 1, [[lent], [workplace.ranked[1]]])
        imitator = artifacts.find(session, parent, "model.bin")
        assert imitator is not None
        imitator.kind = "imitator"
    child = workplace.make_run(parent_run_id=parent)
    with workplace.database.writing() as session:
        runs.delete(session, parent)
    made = make_backup(workplace.settings, tmp_path / "backup")
    assert (made.n_recordings, made.n_runs, made.notices) == (5, 2, ())
    settings = Settings(data=made.folder)
    database = create_database(settings.application_url)
    with database.writing() as session:
        assert [row.id for row in borrowed.listing(session, workplace.behaviour_id)] == [lent]
        rankings.save(session, workplace.behaviour_id, 2, [[workplace.ranked[1]], [lent]])
        assert runs.get(session, child).parent_run_id == parent
    store = ArtifactStore(settings.artifact_root)
    with artifacts.local_file(database, store, parent, "imitator") as file:
        assert file.read_bytes() == MODEL
    database.close()


def test_the_copy_is_consistent_while_writers_are_active(
    workplace: Workplace, tmp_path: Path
) -> None:
    stop, written = threading.Event(), threading.Event()
    finished: list[bool] = []

    def write() -> None:
        # In every transaction the notes of two recordings are made equal.
        number = 0
        while not stop.is_set():
            number += 1
            with workplace.database.writing() as session:
                for key in workplace.ranked[:2]:
                    row = recordings.get(session, key)
                    recordings.update(session, row, notes=f"{number} " * 500)
            written.set()
        finished.append(True)

    writer = threading.Thread(target=write)
    writer.start()
    try:
        assert written.wait(30)
        for number in range(5):
            folder = tmp_path / f"backup-{number}"
            make_backup(workplace.settings, folder)
            with sqlite3.connect(folder / "tril.sqlite") as copy:
                notes = copy.execute(
                    "SELECT notes FROM recordings WHERE id IN (?, ?)", workplace.ranked[:2]
                ).fetchall()
            assert notes[0] == notes[1]
            assert notes[0] != ("",)
    finally:
        stop.set()
        writer.join()
    assert finished == [True], "no write was refused"


def test_caches_and_secrets_are_not_backed_up(workplace: Workplace, tmp_path: Path) -> None:
    data = workplace.settings.data
    (data / "cache").mkdir()
    (data / "cache" / "a.frames").write_bytes(b"x")
    (data / "secrets.json").write_text("{}")
    finished_run(workplace)
    (data / "artifacts" / "runs" / ".half-written").write_bytes(b"x")
    made = make_backup(workplace.settings, tmp_path / "backup")
    names = {path.name for path in made.folder.rglob("*")}
    assert names.isdisjoint({"cache", "a.frames", "secrets.json", ".half-written"})


@pytest.mark.parametrize("name", ["tril.sqlite", "jobs.sqlite", "artifacts"])
def test_a_changed_or_missing_file_is_found(
    workplace: Workplace, tmp_path: Path, name: str
) -> None:
    run_id = finished_run(workplace)
    made = make_backup(workplace.settings, tmp_path / "backup")
    file = made.folder / name
    if file.is_dir():
        file = file / artifacts.path_of(run_id, "model.bin")
    content = bytearray(file.read_bytes())
    content[len(content) // 2] ^= 1
    file.write_bytes(content)
    with pytest.raises(BackupDamaged, match="was changed after"):
        check_backup(made.folder)
    file.unlink()
    with pytest.raises(BackupDamaged, match="is missing"):
        check_backup(made.folder)


def test_a_folder_that_is_not_a_backup_is_refused(tmp_path: Path) -> None:
    with pytest.raises(BackupDamaged, match="not a Tril backup"):
        check_backup(tmp_path)
    manifest = tmp_path / "manifest.json"
    for content, reason in [
        ("{", "can't be read"),
        ("[]", "another format"),
        (json.dumps({"format": "tril-backup", "version": 9}), "another version"),
    ]:
        manifest.write_text(content)
        with pytest.raises(BackupDamaged, match=reason):
            check_backup(tmp_path)


def test_a_file_that_a_training_lost_is_no_whole_backup_and_leaves_nothing(
    workplace: Workplace, tmp_path: Path
) -> None:
    run_id = finished_run(workplace)
    shutil.rmtree(Path(workplace.settings.artifact_root) / "runs" / run_id)
    (tmp_path / "out").mkdir()
    with pytest.raises(BackupDamaged, match=f"run {run_id} is missing"):
        make_backup(workplace.settings, tmp_path / "out" / "backup")
    assert list((tmp_path / "out").iterdir()) == []


def test_files_of_a_training_under_way_may_be_newer(workplace: Workplace, tmp_path: Path) -> None:
    run_id = finished_run(workplace)
    with workplace.database.writing() as session:
        session.get_one(RunRow, run_id).status = RunStatus.RUNNING
    store = ArtifactStore(workplace.settings.artifact_root)
    store.put(artifacts.path_of(run_id, "model.bin"), MODEL * 2)
    made = make_backup(workplace.settings, tmp_path / "backup")
    assert len(made.notices) == 1
    assert "slightly newer" in made.notices[0]


def test_a_training_deleted_between_the_copies_takes_another_try(
    workplace: Workplace, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    run_id = finished_run(workplace)
    copies: list[str] = []

    def copy(source: Path, to: Path) -> None:
        copy_sqlite(source, to)
        copies.append(to.name)
        if copies == ["jobs.sqlite", "tril.sqlite"]:
            with workplace.database.writing() as session:
                row = session.get_one(RunRow, run_id)
                row.deleted_at = row.created_at
            ArtifactStore(workplace.settings.artifact_root).remove_folder(f"runs/{run_id}")

    monkeypatch.setattr(backup, "copy_sqlite", copy)
    made = make_backup(workplace.settings, tmp_path / "backup")
    assert len(copies) == 4
    assert made.n_files == 2


def test_files_that_lie_elsewhere_are_named(workplace: Workplace, tmp_path: Path) -> None:
    finished_run(workplace)
    settings = workplace.settings.model_copy(update={"artifacts_url": "memory://lab"})
    made = make_backup(settings, tmp_path / "backup")
    assert made.n_files == 2
    assert "memory://lab" in made.notices[0]


def test_nothing_is_overwritten(workplace: Workplace, tmp_path: Path) -> None:
    make_backup(workplace.settings, tmp_path / "backup")
    with pytest.raises(Conflict, match="not empty"):
        make_backup(workplace.settings, tmp_path / "backup")
    (tmp_path / "empty").mkdir()
    make_backup(workplace.settings, tmp_path / "empty")


def test_too_little_space_is_reported_before_copying(
    workplace: Workplace, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(backup, "free_bytes", lambda _folder: 10)
    with pytest.raises(Unavailable, match="are free"):
        make_backup(workplace.settings, tmp_path / "backup")
    assert not (tmp_path / "backup").exists()


def test_other_databases_and_folders_without_any_are_refused(tmp_path: Path) -> None:
    elsewhere = Settings(data=tmp_path / "none", database_url="mysql+pymysql://db/tril")
    (tmp_path / "none").mkdir()
    (tmp_path / "none" / "jobs.sqlite").write_bytes(b"")
    with pytest.raises(Unavailable, match="SQLite and PostgreSQL"):
        make_backup(elsewhere, tmp_path / "backup")
    with pytest.raises(Unavailable, match="nothing to back up"):
        make_backup(Settings(data=tmp_path / "none"), tmp_path / "backup")


def _listed(folder: Path) -> None:
    """Let the manifest say what is in a backup's folder, as whoever changed it would."""
    manifest = json.loads((folder / "manifest.json").read_text())
    for entry in manifest["files"]:
        place = folder / entry["path"]
        entry["size_bytes"], entry["blake2b"] = backup._digest(place)
    (folder / "manifest.json").write_text(json.dumps(manifest))


def _with_sql(*statements: str) -> Callable[[Path], None]:
    def change(folder: Path) -> None:
        with closing(sqlite3.connect(folder / "tril.sqlite")) as database:
            for statement in statements:
                database.execute(statement)
            database.commit()
        _listed(folder)

    return change


def _with_path(path: str) -> Callable[[Path], None]:
    def change(folder: Path) -> None:
        manifest = json.loads((folder / "manifest.json").read_text())
        manifest["files"][0]["path"] = path
        (folder / "manifest.json").write_text(json.dumps(manifest))

    return change


def _with_manifest(**members: object) -> Callable[[Path], None]:
    def change(folder: Path) -> None:
        manifest = json.loads((folder / "manifest.json").read_text())
        (folder / "manifest.json").write_text(json.dumps({**manifest, **members}))

    return change


def _with_link(folder: Path) -> None:
    (folder / "jobs.sqlite").rename(folder.parent / "jobs.sqlite")
    (folder / "jobs.sqlite").symlink_to(folder.parent / "jobs.sqlite")


CRAFTED: dict[str, tuple[Callable[[Path], object], str]] = {
    "a trigger": (
        _with_sql("CREATE TRIGGER t AFTER INSERT ON players BEGIN DELETE FROM players; END"),
        "not written by Tril alone: it has 't'",
    ),
    "a view": (_with_sql("CREATE VIEW v AS SELECT 1"), "it has 'v'"),
    "a virtual table": (_with_sql("CREATE VIRTUAL TABLE w USING fts5(a)"), "it has 'w'"),
    "another schema": (_with_sql("DROP TABLE artifacts"), "no database of Tril"),
    "a newer version": (
        _with_sql("UPDATE alembic_version SET version_num = '9999'"),
        "newer version of Tril",
    ),
    "a path outside": (_with_path("../data/tril.sqlite"), "is missing"),
    "an absolute path": (_with_path("/etc/passwd"), "is missing"),
    "a path of another type": (_with_path(3), "can't be read"),  # type: ignore[arg-type]
    "a link": (_with_link, "neither a file nor a folder"),
    "a pipe": (lambda folder: os.mkfifo(folder / "artifacts" / "p"), "neither a file nor"),
    "a log of the database": (
        lambda folder: (folder / "tril.sqlite-wal").write_bytes(b"x"),
        "'tril.sqlite-wal' in .* is not of the backup",
    ),
    "a key": (lambda folder: (folder / "secrets.json").write_text("{}"), "not of the backup"),
    "no files": (_with_manifest(files=None), "can't be read: files"),
    "files of another type": (_with_manifest(files=[{"path": "a"}]), "can't be read"),
    "half of it": (lambda folder: (folder / "tril.sqlite").unlink(), "is missing"),
    "a manifest that is deep": (
        lambda folder: (folder / "manifest.json").write_text("[" * 100_000),
        "nested too deeply",
    ),
}


@pytest.fixture(scope="module")
def backed_up(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("backed-up")
    made = make_workplace(folder / "data")
    finished_run(made)
    make_backup(made.settings, folder / "backup")
    made.database.close()
    return folder / "backup"


@pytest.mark.parametrize("what", CRAFTED)
def test_a_crafted_backup_is_refused_with_a_sentence(
    what: str, backed_up: Path, tmp_path: Path
) -> None:
    change, refusal = CRAFTED[what]
    folder = Path(shutil.copytree(backed_up, tmp_path / "backup"))
    change(folder)
    with pytest.raises(BackupDamaged, match=refusal):
        check_backup(folder)
