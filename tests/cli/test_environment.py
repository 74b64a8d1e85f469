"""What other programs' environments have in common with Tril's: nothing that it notices."""

from __future__ import annotations

import http.server
import json
import os
import subprocess
import sys
import threading
from collections.abc import Mapping
from pathlib import Path

import pytest
from pydantic import SecretStr

from cli.commands.services import ask_server
from cli.join import join_server
from testsupport.databases import on_postgresql
from tril.errors import Unavailable
from tril.settings import Settings

ROOT = Path(__file__).parents[2]
TRIL = [sys.executable, "-m", "cli"]
TINY = ROOT / "tests/data/column-1.jsonl"

pytestmark = pytest.mark.skipif(on_postgresql(), reason="about the environment of a data folder")


@pytest.fixture(scope="module")
def data(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a data folder with a recording, and a behaviour that is called in two scripts."""
    folder = tmp_path_factory.mktemp("data")
    one = folder / "one.jsonl"
    one.write_text(TINY.read_text(encoding="utf-8").splitlines()[0], encoding="utf-8")
    run(folder, "recordings", "import", str(one), "-b", "column-1", "--rank")
    run(folder, "behaviours", "add", "Säule 日本", "--target", "1,1")
    return folder


def run(
    data: Path,
    *arguments: str,
    cwd: Path | None = None,
    environ: Mapping[str, str] | None = None,
) -> subprocess.CompletedProcess[bytes]:
    done = subprocess.run(
        [*TRIL, *arguments],
        cwd=cwd,
        env={**os.environ, "PYTHONPATH": str(ROOT), "TRIL_DATA": str(data), **(environ or {})},
        capture_output=True,
        check=False,
    )
    assert b"Traceback" not in done.stderr, done.stderr.decode()
    return done


ROMS_ELSEWHERE = {"ALE_ROMS_DIR": "/usr"}

FOREIGN = {
    "ALE_ROMS_DIR": "/nowhere",
    # A backend that is not installed.
    "MPLBACKEND": "module://nowhere",
    # Folders that are missing.
    "HOME": "/nowhere",
    "TMPDIR": "/nowhere",
    "XDG_CACHE_HOME": "/nowhere",
    "MPLCONFIGDIR": "/proc/nowhere",
    # A locale without letters.
    "LC_ALL": "C",
    "PYTHONUTF8": "0",
    "PYTHONCOERCECLOCALE": "0",
    "PYTHONIOENCODING": "ascii",
    # A terminal.
    "COLUMNS": "3",
    "NO_COLOR": "1",
    "TERM": "x",
    "TZ": "x/y",
    # Other applications.
    "DBOS__CLOUD": "true",
    "DBOS__VMID": "x",
    "PGHOST": "/nowhere",
    "PORT": "x",
    "WEB_CONCURRENCY": "x",
}
"""All at once: each command takes seconds to start, and none of these hides another."""


@pytest.mark.parametrize("foreign", [ROMS_ELSEWHERE, FOREIGN], ids=["ROMs", "everything"])
def test_only_what_is_asked_for_is_printed(data: Path, foreign: dict[str, str]) -> None:
    done = run(data, "recordings", "verify", "-b", "column-1", environ=foreign)
    assert (done.returncode, done.stdout) == (0, b"1 of 1 recordings verify.\n"), done.stderr
    listed = json.loads(run(data, "behaviours", "list", "--json", environ=foreign).stdout)
    assert "Säule 日本" in [one["name"] for one in listed]


def test_whatever_learns_is_loaded_and_keeps_its_queue() -> None:
    program = (
        "import trainer.runtime.worker, trainer.reporting.figures, tempfile, matplotlib\n"
        "from pathlib import Path\n"
        "from tril.jobs.queue import executor_config\n"
        "from tril.settings import Settings\n"
        "from dbos import DBOS\n"
        "settings = Settings(data=Path(tempfile.mkdtemp()))\n"
        "from tril.jobs import prepare_queue\n"
        "prepare_queue(settings)\n"
        "found = DBOS(config=executor_config(settings, 'worker-0'))._config\n"
        "print(found['name'], found['system_database_url'] == settings.queue_url)\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", program],
        cwd=ROOT,
        env={**os.environ, **FOREIGN},
        capture_output=True,
        check=False,
    )
    assert done.stdout == b"tril True\n", done.stderr.decode()


def test_figures_are_drawn_alike_whatever_a_matplotlibrc_says(tmp_path: Path) -> None:
    (tmp_path / "matplotlibrc").write_text("font.size: 40\n", encoding="utf-8")
    program = (
        "import trainer.reporting.figures, matplotlib\nprint(matplotlib.rcParams['font.size'])"
    )
    done = subprocess.run(
        [sys.executable, "-c", program],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        capture_output=True,
        check=True,
    )
    assert done.stdout == b"10.0\n"


def test_a_file_of_settings_that_is_no_text_is_named(data: Path, tmp_path: Path) -> None:
    (tmp_path / ".env").write_bytes("TRIL_PORT=80\n".encode("utf-16"))
    done = run(data, "behaviours", "list", cwd=tmp_path)
    assert done.returncode == 1
    assert f"The file .env in {tmp_path} can't be read" in done.stderr.decode()


def test_no_data_folder_is_chosen_by_an_empty_setting(tmp_path: Path) -> None:
    done = run(Path(), "behaviours", "list", cwd=tmp_path, environ={"TRIL_DATA": ""})
    assert done.returncode == 1
    assert "TRIL_DATA=: Value error, name a folder" in done.stderr.decode()
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("command", "closed"),
    [
        ("behaviours list --json", "<&- >&- 2>&-"),
        ("behaviours list", "| head -1"),
        ("recordings export -b column-1", ">&-"),
        ("recordings export -b column-1", "| true"),
    ],
)
def test_who_does_not_listen_gets_no_traceback(data: Path, closed: str, command: str) -> None:
    done = subprocess.run(
        ["sh", "-c", f"{sys.executable} -m cli {command} {closed}"],
        cwd=ROOT,
        env={**os.environ, "TRIL_DATA": str(data)},
        capture_output=True,
        check=False,
    )
    assert b"Traceback" not in done.stderr, done.stderr.decode()


def test_this_machine_is_asked_without_a_proxy(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    class Answer(http.server.BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            self.send_response(200)
            self.end_headers()

        def do_POST(self) -> None:
            self.rfile.read(int(self.headers["Content-Length"]))
            self.send_error(404)

        def log_message(self, *_: object) -> None: ...

    for name in ("http_proxy", "https_proxy", "all_proxy"):
        monkeypatch.setenv(name, "http://192.0.2.1:9")
        monkeypatch.setenv(name.upper(), "http://192.0.2.1:9")
    with http.server.HTTPServer(("127.0.0.1", 0), Answer) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        port = server.server_address[1]
        settings = Settings(data=tmp_path, port=port, worker_key=SecretStr("key"))
        ask_server(settings)
        with pytest.raises(Unavailable, match="no server of this version"):
            join_server(settings, f"http://127.0.0.1:{port}")
        server.shutdown()


def test_a_worker_without_a_standard_input_says_that_the_key_is_missing(data: Path) -> None:
    done = subprocess.run(
        ["sh", "-c", f"{sys.executable} -m cli worker --join http://127.0.0.1:1 <&-"],
        cwd=ROOT,
        env={**os.environ, "TRIL_DATA": str(data)},
        capture_output=True,
        check=False,
    )
    assert b"Which key?" in done.stderr
