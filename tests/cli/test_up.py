"""What keeps ``tril up`` from starting is said in one sentence."""

from __future__ import annotations

import errno
import os
import subprocess
import sys
from pathlib import Path

import pytest
import typer
from typer.testing import CliRunner

from cli.main import app
from cli.output import readable_errors
from cli.supervision.lock import lock_data_folder
from cli.workspace import migrate_databases
from testsupport.databases import on_postgresql
from trainer.runtime.worker import worker_name
from tril.errors import Unavailable
from tril.settings import Settings


def _refusal(*arguments: str) -> str:
    done = CliRunner().invoke(app, list(arguments))
    assert done.exit_code == 1, done.output
    assert "Traceback" not in done.output
    return " ".join(done.output.split())


def test_a_data_folder_is_used_by_one_supervisor_at_a_time(tmp_path: Path) -> None:
    with (
        lock_data_folder(tmp_path, "http://127.0.0.1:8000"),
        pytest.raises(Unavailable, match=r"already runs.*127.0.0.1:8000.*TRIL_DATA"),
        lock_data_folder(tmp_path, "http://127.0.0.1:8001"),
    ):
        pass
    with lock_data_folder(tmp_path, "http://127.0.0.1:8001"):
        pass


def test_a_misspelt_setting_is_named_with_the_one_that_was_meant(
    data_folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    data_folder.mkdir(exist_ok=True)
    monkeypatch.setenv("TRIL_LEARNING_THREAD", "2")
    monkeypatch.setenv("TRIL_XYZZY", "2")
    with lock_data_folder(data_folder, "http://127.0.0.1:8000"):
        said = _refusal("up", "--port", "0", "--no-browser")
    assert "TRIL_LEARNING_THREAD is no setting of Tril. Did you mean TRIL_LEARNING_THREADS?" in said
    assert "TRIL_XYZZY is no setting of Tril." in said
    assert said.count("Did you mean") == 1


def test_a_second_start_on_the_same_folder_is_refused(data_folder: Path) -> None:
    data_folder.mkdir(exist_ok=True)
    with lock_data_folder(data_folder, "http://127.0.0.1:8000"):
        assert "Tril already runs on" in _refusal("up", "--port", "0", "--no-browser")


@pytest.mark.parametrize("command", ["up", "serve", "worker", "migrate"])
def test_a_data_path_that_is_a_file_is_refused(
    command: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = tmp_path / "file"
    file.touch()
    monkeypatch.setenv("TRIL_DATA", str(file))
    assert "which is not a folder" in _refusal(command)
    monkeypatch.setenv("TRIL_DATA", str(file / "below"))
    if command in {"up", "migrate"}:
        assert "can't be created" in _refusal(command)


@pytest.mark.skipif(on_postgresql(), reason="about SQLite's files")
@pytest.mark.parametrize("command", ["up", "migrate"])
@pytest.mark.parametrize("name", ["tril.sqlite", "jobs.sqlite"])
def test_a_damaged_database_is_named_with_a_way_out(
    command: str, name: str, data_folder: Path
) -> None:
    data_folder.mkdir(exist_ok=True)
    (data_folder / name).write_bytes(b"no database" * 1000)
    arguments = ["--port", "0", "--no-browser"] if command == "up" else []
    refusal = _refusal(command, *arguments)
    assert "file is not a database" in refusal
    assert "backup" in refusal


def test_damaged_secrets_are_refused_before_anything_starts(data_folder: Path) -> None:
    settings = Settings()
    migrate_databases(settings)
    settings.token_file.write_text("{")
    assert f"{settings.token_file} can't be read" in _refusal("up", "--port", "0", "--no-browser")
    assert data_folder.exists()


def test_a_setting_that_makes_no_sense_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("TRIL_PORT", "eighty")
    assert "TRIL_PORT=eighty" in _refusal("health", "server")


@pytest.mark.parametrize(
    ("call", "code", "said"),
    [
        ("tempfile.TemporaryFile", errno.EROFS, "Nothing can be written"),
        ("tempfile.TemporaryFile", errno.ENOSPC, "No space left on device"),
        ("fcntl.lockf", errno.ENOLCK, "has no locks"),
        ("fcntl.flock", errno.EOPNOTSUPP, "has no locks"),
    ],
)
def test_a_data_folder_that_can_not_be_used_is_refused_with_what_to_do(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, call: str, code: int, said: str
) -> None:
    def refuse(*_arguments: object, **_options: object) -> None:
        raise OSError(code, os.strerror(code))

    monkeypatch.setenv("TRIL_DATA", str(tmp_path))
    monkeypatch.setattr(f"cli.workspace.{call}", refuse)
    refusal = _refusal("status")
    assert said in refusal
    assert "TRIL_DATA" in refusal
    assert not list(tmp_path.iterdir())


def test_a_worker_says_that_there_are_no_locks_and_not_that_there_are_too_many_workers(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def refuse(*_arguments: object) -> None:
        raise OSError(errno.ENOLCK, os.strerror(errno.ENOLCK))

    monkeypatch.setattr("trainer.runtime.worker.fcntl.lockf", refuse)
    with pytest.raises(typer.Exit), readable_errors(), worker_name(tmp_path):
        pass
    assert "No locks available. Choose a data folder" in " ".join(capsys.readouterr().err.split())


@pytest.mark.parametrize("command", ["up", "serve"])
def test_a_limit_on_open_files_that_is_too_low_is_refused_before_anything_starts(
    command: str, data_folder: Path
) -> None:
    done = subprocess.run(
        ["sh", "-c", f"ulimit -n 256; exec {sys.executable} -m cli {command}"],
        capture_output=True,
        text=True,
    )
    assert done.returncode == 1
    assert "Allow more (ulimit -n 992)" in done.stderr


def test_as_many_files_as_connections_need_may_be_open(data_folder: Path) -> None:
    code = (
        "import resource as r; r.setrlimit(r.RLIMIT_NOFILE, (256, 4096));"
        "from server.open_files import allow_open_files; from tril.settings import Settings;"
        "allow_open_files(Settings(max_connections=2000)); print(r.getrlimit(r.RLIMIT_NOFILE))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "(2224, 4096)\n"
