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

from testsupport.processes import tril_process, whole_tril
from testsupport.recipes import SMALLEST
from tril.settings import Settings

ROOT = Path(__file__).resolve().parents[2]
PACKAGES = ("cli", "migrations", "server", "trainer", "tril")

pytestmark = [pytest.mark.lengthy, pytest.mark.timeout(600)]


@pytest.fixture(scope="module")
def programs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the programs of an environment that Tril was installed into, from its wheel alone."""
    dist = tmp_path_factory.mktemp("dist")
    # Pytest may have been started by a make, whose flags must not reach this one.
    environ = {k: v for k, v in os.environ.items() if k not in {"MAKEFLAGS", "MAKELEVEL", "ARGS"}}
    make = ["make", "--silent", "wheel", f"DIST={dist}"]
    with (ROOT / "pyproject.toml").open() as lock:
        # Two of pytest's processes may have tests of this module, and both builds empty the same
        # folder of the page first.
        fcntl.flock(lock, fcntl.LOCK_EX)
        subprocess.run(make, cwd=ROOT, env=environ, check=True)
    (wheel,) = dist.glob("*.whl")

    environment = tmp_path_factory.mktemp("environment")
    venv.create(environment)
    python = str(environment / "bin/python")
    pip = [sys.executable, "-m", "pip", "--python", python, "install"]
    subprocess.run([*pip, "--quiet", "--no-index", "--no-deps", str(wheel)], check=True)
    # What Tril needs comes from this environment: installing it anew would take minutes.
    packages = sysconfig.get_path("purelib", "venv", {"base": str(environment)})
    (Path(packages) / "dependencies.pth").write_text(sysconfig.get_path("purelib"))
    return environment / "bin"


@pytest.fixture
def how(programs: Path, tmp_path: Path) -> dict[str, Any]:
    """Return how to run the installed command: in a folder whose modules have names of Tril's."""
    for package in PACKAGES:
        (tmp_path / f"{package}.py").write_text("raise ImportError('This is not Tril.')\n")
    return {"command": [programs / "tril"], "cwd": tmp_path, "environ": {"PATH": str(programs)}}


def test_every_package_is_the_wheels(programs: Path) -> None:
    program = f"import {', '.join(PACKAGES)}\nprint(*(m.__file__ for m in ({', '.join(PACKAGES)})))"
    done = subprocess.run(
        [programs / "python", "-P", "-c", program], capture_output=True, text=True, check=True
    )
    for file in done.stdout.split():
        assert Path(file).is_relative_to(programs.parent)


def test_tril_up_serves_the_page(how: dict[str, Any], tmp_path: Path) -> None:
    with (
        whole_tril(tmp_path / "data", **how) as tril,
        httpx2.Client(follow_redirects=True) as browser,
    ):
        page = browser.get(tril.address).raise_for_status().text
        (script,) = re.findall(r'src="(/assets/[^"]+\.js)"', page)
        assert len(browser.get(tril.base_url + script).raise_for_status().text) > 100_000


def test_the_demo_ends_with_a_summary(how: dict[str, Any], tmp_path: Path) -> None:
    summary = tmp_path / "summary"
    arguments = ["demo", "--steps", "2048", "--output", str(summary)]
    arguments += [word for value in (*SMALLEST, "policy.n_steps=128") for word in ("--set", value)]
    with tril_process(Settings(data=tmp_path / "data"), *arguments, **how) as demo:
        status = demo.process.wait()
    assert status == 0, "".join(demo.output)
    assert "scripted demonstrator" in (summary / "README.md").read_text()
