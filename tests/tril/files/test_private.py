"""Nobody but the user of a data folder reads what is in it."""

from __future__ import annotations

import os
import stat
from collections.abc import Iterator
from pathlib import Path

import pytest
from typer.testing import CliRunner

from cli.main import app
from testsupport.databases import on_postgresql
from tril.files.private import make_private


@pytest.fixture(autouse=True)
def usual_umask() -> Iterator[None]:
    before = os.umask(0o022)
    yield
    os.umask(before)


def _open_to_others(folder: Path) -> list[str]:
    every = [folder, *folder.rglob("*")]
    return [str(path) for path in every if stat.S_IMODE(path.lstat().st_mode) & 0o077]


@pytest.mark.skipif(on_postgresql(), reason="a backup is a data folder with SQLite alone")
def test_what_commands_make_is_their_users_alone(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    data, out = tmp_path / "data", tmp_path / "out"
    out.mkdir(mode=0o700)
    monkeypatch.setenv("TRIL_DATA", str(data))
    for command in (
        ["people", "list"],
        ["behaviours", "export", "column-1", "-o", str(out / "behaviour.json")],
        ["recordings", "export", "-b", "column-1", "-o", str(out / "recordings.jsonl")],
        ["backup", str(out / "backup")],
    ):
        done = CliRunner().invoke(app, command)
        assert done.exit_code == 0, done.output
    assert (data / "tril.sqlite").exists()
    assert (data / "jobs.sqlite").exists()
    assert not _open_to_others(data)
    assert not _open_to_others(out)


def test_a_folder_of_an_earlier_version_is_closed(tmp_path: Path) -> None:
    data = tmp_path / "data"
    (data / "artifacts" / "run").mkdir(parents=True)
    for name in ("tril.sqlite", "tril.sqlite-wal", "jobs.sqlite", "artifacts/run/net.safetensors"):
        (data / name).write_text("")
    (data / "artifacts" / "elsewhere").symlink_to(tmp_path)
    before = tmp_path.stat().st_mode
    assert make_private(data)
    assert [path for path in _open_to_others(data) if not Path(path).is_symlink()] == []
    assert tmp_path.stat().st_mode == before, "what a link leads to stays as it is"
    assert make_private(data)


def test_a_folder_with_other_things_in_it_stays_as_it_is_and_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "letters").mkdir()
    tmp_path.chmod(0o755)
    assert not make_private(tmp_path)
    assert stat.S_IMODE(tmp_path.stat().st_mode) == 0o755
    monkeypatch.setenv("TRIL_DATA", str(tmp_path))
    done = CliRunner().invoke(app, ["people", "list"])
    assert done.output.count(f"chmod -R go-rwx {tmp_path}") == 1
