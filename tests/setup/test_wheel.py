"""The wheel is all that Tril needs: no clone, no Node.js."""

from __future__ import annotations

import os
import queue
import re
import signal
import subprocess
import sys
import sysconfig
import threading
import urllib.request
import venv
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
ADDRESS = re.compile(r"http://\S+\?token=\S+")
START_TIMEOUT_S = 120

pytestmark = [pytest.mark.lengthy, pytest.mark.timeout(600)]


@pytest.fixture(scope="module")
def installed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return an environment's folder of programs, where Tril was installed from its wheel alone."""
    dist = tmp_path_factory.mktemp("dist")
    # Pytest may have been started by a make, whose flags must not reach this one.
    environ = {k: v for k, v in os.environ.items() if k not in {"MAKEFLAGS", "MAKELEVEL", "ARGS"}}
    make = ["make", "--silent", "wheel", f"DIST={dist}"]
    subprocess.run(make, cwd=ROOT, env=environ, check=True)
    (wheel,) = dist.glob("*.whl")

    environment = tmp_path_factory.mktemp("environment")
    venv.create(environment, symlinks=True, with_pip=False)
    packages = Path(sysconfig.get_path("purelib", vars={"base": str(environment)}))
    pip = [sys.executable, "-m", "pip", "--disable-pip-version-check", "--python"]
    python = str(environment / "bin/python")
    install = ["install", "--quiet", "--no-deps", "--no-index", str(wheel)]
    subprocess.run([*pip, python, *install], check=True)
    # Tril's dependencies are those of this environment; installing them anew would take minutes.
    (packages / "dependencies.pth").write_text(sysconfig.get_path("purelib"))
    return environment / "bin"


@pytest.fixture
def elsewhere(tmp_path: Path) -> Path:
    """Return a current folder with modules that are called as Tril's are."""
    for name in ("cli", "server", "tril", "trainer", "migrations"):
        (tmp_path / f"{name}.py").write_text("raise ImportError('This is not Tril.')\n")
    return tmp_path


def environ_of(programs: Path, data: Path) -> dict[str, str]:
    return {"PATH": str(programs), "TRIL_DATA": str(data), "COLUMNS": "200"}


@pytest.fixture
def address(installed: Path, elsewhere: Path) -> Iterator[str]:
    """Return the address that ``tril up`` prints."""
    process = subprocess.Popen(
        [installed / "tril", "up", "--port", "0", "--no-browser"],
        cwd=elsewhere,
        env=environ_of(installed, elsewhere / "data"),
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )
    said: list[str] = []
    found: queue.Queue[str] = queue.Queue()

    def read() -> None:
        assert process.stdout is not None
        with process.stdout:
            for line in process.stdout:
                said.append(line)
                if match := ADDRESS.search(line):
                    found.put(match.group())

    reader = threading.Thread(target=read)
    reader.start()
    try:
        yield found.get(timeout=START_TIMEOUT_S)
    except queue.Empty:
        pytest.fail("tril up printed no address:\n" + "".join(said))
    finally:
        process.send_signal(signal.SIGINT)
        assert process.wait(30) == 0, "".join(said)
        reader.join()


def test_tril_is_imported_from_the_wheel(installed: Path, elsewhere: Path) -> None:
    program = "import cli, migrations, server, trainer, tril\nprint(tril.__file__)"
    done = subprocess.run(
        [installed / "python", "-P", "-c", program],
        cwd=elsewhere,
        env=environ_of(installed, elsewhere / "data"),
        capture_output=True,
        text=True,
        check=True,
    )
    assert Path(done.stdout.strip()).is_relative_to(installed.parent)


def test_tril_up_serves_the_page(address: str) -> None:
    opener = urllib.request.build_opener(urllib.request.HTTPCookieProcessor())
    with opener.open(address) as answer:
        page = answer.read().decode()
    (script,) = re.findall(r'src="(/assets/[^"]+\.js)"', page)
    with opener.open(address.split("/?")[0] + script) as answer:
        assert "javascript" in answer.headers["Content-Type"]
        assert len(answer.read()) > 100_000


def test_the_demo_ends_with_a_summary(installed: Path, elsewhere: Path) -> None:
    summary = elsewhere / "summary"
    subprocess.run(
        [installed / "tril", "demo", "--steps", "2048", "--output", summary],
        cwd=elsewhere,
        env=environ_of(installed, elsewhere / "data"),
        check=True,
    )
    assert "scripted demonstrator" in (summary / "README.md").read_text()
