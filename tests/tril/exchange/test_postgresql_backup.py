"""A backup of PostgreSQL, and the commands of docs/databases.md that restore it."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.tril.exchange.samples import MODEL, finished_run
from testsupport.databases import CHOICE
from testsupport.postgres import cluster, find_or_install
from testsupport.workplace import Workplace, make_workplace
from tril.exchange.backup import BackupDamaged, check_backup, make_backup
from tril.files.artifact_store import ArtifactStore
from tril.jobs import Jobs
from tril.settings import Settings
from tril.store import behaviours, rankings
from tril.store.copies import CopyFailed
from tril.store.database import create_database
from tril.store.schema import check_schema
from tril.store.training import artifacts, runs

ROOT = Path(__file__).parents[3]


@pytest.fixture
def workplace(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Workplace]:
    if find_or_install() is None:
        pytest.skip("needs PostgreSQL's initdb and postgres; none is installed or installable")
    monkeypatch.setenv(CHOICE, "postgresql")
    made = make_workplace(tmp_path / "data")
    yield made
    made.database.close()


def documented_restore() -> str:
    """The commands under the heading "Restore"."""
    page = (ROOT / "docs" / "databases.md").read_text()
    return page.split("\n## Restore\n")[1].split("```sh\n")[1].split("```")[0]


def test_the_documented_commands_restore_a_backup(workplace: Workplace, tmp_path: Path) -> None:
    run_id = finished_run(workplace)
    waiting = workplace.make_run()
    made = make_backup(workplace.settings, tmp_path / "backup")
    assert (made.n_recordings, made.n_runs, made.n_files, made.notices) == (4, 2, 2, ())
    assert check_backup(made.folder) == made
    # Of what comes after the backup, nothing is in it.
    with workplace.database.writing() as session:
        rankings.save(session, workplace.behaviour_id, 1, [list(workplace.ranked)])

    server = cluster()
    server.drop("tril_restored")
    server.create("tril_restored")
    url = server.url("tril_restored")
    (tmp_path / "bin").mkdir()
    tril = tmp_path / "bin" / "tril"
    tril.write_text(f'#!/bin/sh\nPYTHONPATH="{ROOT}" exec "{sys.executable}" -m cli "$@"\n')
    tril.chmod(0o755)
    done = subprocess.run(
        ["sh", "-eu", "-c", documented_restore()],
        env={
            "PATH": f"{tmp_path / 'bin'}:{os.environ['PATH']}",
            "FOLDER": str(made.folder),
            "NEW": url.replace("postgresql+psycopg", "postgresql"),
            "TRIL_DATA": str(tmp_path / "restored"),
        },
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr

    settings = Settings(data=tmp_path / "restored", database_url=url)
    database = create_database(url)
    check_schema(database)
    with database.writing() as session:
        behaviour = behaviours.by_slug(session, "column-1")
        tiers = rankings.current(session, behaviour.id).tiers
        assert tiers == [[key] for key in workplace.ranked]
        assert {row.id for row in runs.listing(session)} == {run_id, waiting}
        # Ids go on where they were.
        rankings.save(session, behaviour.id, 1, [list(workplace.ranked)])
    store = ArtifactStore(settings.artifact_root)
    assert store.get(artifacts.path_of(run_id, "model.bin")) == MODEL
    jobs = Jobs(database, settings)
    jobs.reconcile()
    assert set(jobs._jobs([run_id, waiting])) == {waiting}
    jobs.close()
    database.close()
    server.drop("tril_restored")


def test_a_damaged_dump_and_a_missing_file_are_found(workplace: Workplace, tmp_path: Path) -> None:
    run_id = finished_run(workplace)
    folder = make_backup(workplace.settings, tmp_path / "backup").folder
    copy = tmp_path / "copy"
    shutil.copytree(folder, copy)
    with (copy / "tril.dump").open("ab") as dump:
        dump.write(b"x")
    with pytest.raises(BackupDamaged, match=r"tril\.dump .* was changed"):
        check_backup(copy)
    ArtifactStore(workplace.settings.artifact_root).remove_folder(f"runs/{run_id}")
    with pytest.raises(BackupDamaged, match=f"run {run_id} is missing"):
        make_backup(workplace.settings, tmp_path / "second")


def test_a_queue_in_a_database_of_its_own_is_in_the_backup(
    workplace: Workplace, tmp_path: Path
) -> None:
    server = cluster()
    server.drop("tril_queue")
    server.create("tril_queue")
    settings = workplace.settings.model_copy(update={"jobs_database_url": server.url("tril_queue")})
    made = make_backup(settings, tmp_path / "backup")
    assert sorted(path.name for path in made.folder.iterdir()) == [
        "jobs.dump",
        "manifest.json",
        "tril.dump",
    ]
    assert check_backup(made.folder) == made
    server.drop("tril_queue")


def test_without_pg_dump_the_message_says_what_to_install(
    workplace: Workplace, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(CopyFailed, match=r"there is no pg_dump.*apt install postgresql-client"):
        make_backup(workplace.settings, tmp_path / "backup")
    assert not (tmp_path / "backup").exists()
