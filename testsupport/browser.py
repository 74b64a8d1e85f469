"""The Chromium that the page is looked at in; installed where there is none."""

from __future__ import annotations

import contextlib
import fcntl
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

from playwright.sync_api import Browser, Playwright

NAMES = ("chromium", "google-chrome", "google-chrome-stable", "chromium-browser")
OS_RELEASE = Path("/etc/os-release")
INSTALL_TIMEOUT_S = 400.0
"""Of one command of the packages' manager: a hundred megabytes over a slow line."""
ARGUMENTS = (
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
)


def launch_chromium(playwright: Playwright) -> Browser:
    """Launch a headless Chromium: this machine's, else Playwright's own."""
    install_chromium()
    return playwright.chromium.launch(
        executable_path=find_chromium(),
        chromium_sandbox=os.geteuid() != 0,
        args=ARGUMENTS,
    )


def install_chromium() -> None:
    """Install a Chromium where there is none: Debian's as root on Debian, else Playwright's.

    Processes that ask at the same time wait for the first of them.

    Raises:
        RuntimeError: None could be installed.
    """
    with _alone("chromium"):
        # Ubuntu's package of that name is a stub for another package system.
        if find_chromium() is None:
            install_debian_packages("chromium")
        if find_chromium() is None:
            command = [sys.executable, "-m", "playwright", "install", "chromium"]
            if subprocess.run(command, stdout=sys.stderr, check=False).returncode:
                raise RuntimeError(
                    "The browser tests need a Chromium, and none could be installed. Install "
                    "Chromium or Google Chrome, or name one: "
                    "CHROMIUM=/path/to/chromium make test"
                )


def install_debian_packages(*packages: str) -> None:
    """Try to install packages, as root on Debian alone; gives up where it takes very long."""
    if os.geteuid() != 0 or not _is_debian():
        return
    quiet = {**os.environ, "DEBIAN_FRONTEND": "noninteractive"}
    install = ["apt-get", "install", "--yes", "--no-install-recommends", *packages]
    with _alone("packages"):
        for command in (["apt-get", "update"], install):
            with contextlib.suppress(subprocess.TimeoutExpired):
                subprocess.run(
                    command, env=quiet, stdout=sys.stderr, check=False, timeout=INSTALL_TIMEOUT_S
                )


@contextlib.contextmanager
def _alone(what: str) -> Iterator[None]:
    """Let other processes of this user wait before the same block: apt has one lock for all."""
    path = Path(tempfile.gettempdir()) / f"tril-tests-{os.getuid()}-{what}.lock"
    with path.open("w") as file:
        fcntl.flock(file, fcntl.LOCK_EX)
        yield


def find_chromium() -> str | None:
    """Return the Chromium that CHROMIUM names, else one on the PATH that starts.

    Raises:
        RuntimeError: What CHROMIUM names does not start.
    """
    if named := os.environ.get("CHROMIUM"):
        if not _starts(named):
            raise RuntimeError(f"CHROMIUM names '{named}', but '{named} --version' fails.")
        return named
    paths = filter(None, map(shutil.which, NAMES))
    return next(filter(_starts, paths), None)


def _starts(program: str) -> bool:
    """Tell whether a browser runs here (a missing library or a stub makes it fail)."""
    try:
        return subprocess.run([program, "--version"], capture_output=True).returncode == 0
    except OSError:
        return False


def _is_debian() -> bool:
    return (
        OS_RELEASE.exists() and "ID=debian" in OS_RELEASE.read_text(encoding="utf-8").splitlines()
    )
