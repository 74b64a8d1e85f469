"""The wheel is all that Tril needs: no clone, no Node.js."""

from __future__ import annotations

import fcntl
import os
import re
import subprocess
import sys
import sysconfig
import venv
from pathlib import Path
from typing import Any

import httpx2
import pytest

from testsupport.processes import whole_tril

ROOT = Path(__file__).resolve().parents[2]
PACKAGES = ("cli", "migrations", "server", "trainer", "tril")

pytestmark = [pytest.mark.lengthy, pytest.mark.timeout(600)]


@pytest.fixture(scope="module")
def programs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the programs of an environment that Tril was installed into, from its wheel alone."""
    folder = tmp_path_factory.getbasetemp()
    if "PYTEST_XDIST_WORKER" in os.environ:
        # Each of pytest's processes may have a test of this module; the first makes it for all.
        folder = folder.parent
    environment, installed = folder / "environment", folder / "installed"
    with (folder / "wheel.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not installed.exists():
            _install(folder / "dist", environment)
            installed.touch()
    return environment / "bin"


def _install(dist: Path, environment: Path) -> None:
    """Build the wheel in a folder and install it into a new environment."""
    # Pytest may have been started by a make, whose flags must not reach this one.
    environ = {k: v for k, v in os.environ.items() if k not in {"MAKEFLAGS", "MAKELEVEL", "ARGS"}}
    make = ["make", "--silent", "wheel", f"DIST={dist}"]
    subprocess.run(make, cwd=ROOT, env=environ, check=True)
    (wheel,) = dist.glob("*.whl")
    venv.create(environment, clear=True)
    python = str(environment / "bin/python")
    pip = [sys.executable, "-m", "pip", "--python", python, "install"]
    subprocess.run([*pip, "--quiet", "--no-index", "--no-deps", str(wheel)], check=True)
    # What Tril needs comes from this environment: installing it anew would take minutes.
    packages = sysconfig.get_path("purelib", "venv", {"base": str(environment)})
    (Path(packages) / "dependencies.pth").write_text(sysconfig.get_path("purelib"))


@pytest.fixture
def how(programs: Path, tmp_path: Path) -> dict[str, Any]:
    """Return how to run the installed command: in a folder whose modules have names of Tril's."""
    for package in PACKAGES:
        (tmp_path / f"{package}.py").write_text("raise ImportError('This is not Tril.')\n")
    return {"command": [programs / "tril"], "cwd": tmp_path, "environ": {"PATH": str(programs)}}


def test_every_package_is_the_wheels_and_whole(programs: Path) -> None:
    program = f"import {', '.join(PACKAGES)}\nprint(*(m.__file__ for m in ({', '.join(PACKAGES)})))"
    done = subprocess.run(
        [programs / "python", "-P", "-c", program], capture_output=True, text=True, check=True
    )
    installed = [Path(file).parent for file in done.stdout.split()]
    tracked = subprocess.run(
        ["git", "ls-files", *PACKAGES], cwd=ROOT, capture_output=True, text=True, check=True
    ).stdout.splitlines()
    for package in installed:
        assert package.is_relative_to(programs.parent)
        own = {file for file in tracked if file.startswith(f"{package.name}/")}
        assert own
        assert [file for file in own if not (package.parent / file).is_file()] == []


def test_tril_up_serves_the_page(how: dict[str, Any], tmp_path: Path) -> None:
    with (
        whole_tril(tmp_path / "data", **how) as tril,
        httpx2.Client(follow_redirects=True) as browser,
    ):
        page = browser.get(tril.address).raise_for_status().text
        (script,) = re.findall(r'src="(/assets/[^"]+\.js)"', page)
        assert len(browser.get(tril.base_url + script).raise_for_status().text) > 50_000


def test_games_are_played_by_processes_that_it_starts(how: dict[str, Any], programs: Path) -> None:
    program = """
from tril.games import game_named
from tril.play.vector.vector_game import TrainingStarts, VectorGame
game = game_named("space_invaders")
with VectorGame(game, 2, TrainingStarts(game), n_processes=2, training_seed=0) as games:
    print(games.reset().shape)
"""
    done = subprocess.run(
        [programs / "python", "-c", program],
        cwd=how["cwd"],
        env=how["environ"] | {"PYTHONSAFEPATH": "1"},  # as the installed command has it
        capture_output=True,
        text=True,
        check=False,
    )
    assert (done.returncode, done.stdout) == (0, "(2, 4, 84, 84)\n"), done.stderr
