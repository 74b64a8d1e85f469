"""Find the Chromium that the browser tests run in, and install one where there is none.

``python scripts/browser.py`` prints its path. In this order: what CHROMIUM names; a chromium,
google-chrome or chromium-browser on the PATH; Debian's package, as root on Debian; Playwright's
own download. The tests never skip: where all of that fails, the message says what to install.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path

NAMES = ("chromium", "google-chrome", "google-chrome-stable", "chromium-browser")
OS_RELEASE = Path("/etc/os-release")
START_TIMEOUT_S = 60.0


class NoBrowser(Exception):
    """No Chromium was found or could be installed; the message says what to do."""


def find_browser(environ: Mapping[str, str] = os.environ) -> Path:
    """Return a Chromium that starts, installing one if need be.

    Args:
        environ: Environment whose CHROMIUM and PATH are looked at.

    Raises:
        NoBrowser: CHROMIUM names none, or there is none and none could be installed.
    """
    search_path = environ.get("PATH", os.defpath)
    if named := environ.get("CHROMIUM"):
        return _named_browser(named, search_path)
    reasons = []
    for step in (_on_path, _from_debian, _from_playwright):
        found = step(search_path)
        if isinstance(found, Path):
            return found
        reasons.append(found)
    raise NoBrowser(
        "the browser tests need a Chromium, and there is none: "
        + "; ".join(reasons)
        + ". Install Chromium or Google Chrome, or name one: CHROMIUM=/path/to/chromium make test"
    )


def starts(program: str) -> bool:
    """Tell whether a browser's program runs here (a missing library or a stub makes it fail)."""
    try:
        done = subprocess.run(
            [program, "--version"], capture_output=True, timeout=START_TIMEOUT_S, check=False
        )
    except (OSError, subprocess.TimeoutExpired):
        return False
    return done.returncode == 0


def can_use_apt(user_id: int, search_path: str, os_release: str) -> str | None:
    """Return why Debian's package cannot be installed here, or None when it can.

    Ubuntu's package of that name is a stub for another package system, so Debian itself is asked.
    """
    lines = {line.strip().replace('"', "") for line in os_release.splitlines()}
    if "ID=debian" not in lines:
        return "this is not Debian, so apt-get was not asked"
    if shutil.which("apt-get", path=search_path) is None:
        return "there is no apt-get"
    return None if user_id == 0 else "apt-get was not asked because it needs root"


def _named_browser(named: str, search_path: str) -> Path:
    program = shutil.which(named, path=search_path)
    if program is None:
        raise NoBrowser(f"CHROMIUM names '{named}', which is no program. Name one, or unset it.")
    if not starts(program):
        raise NoBrowser(
            f"CHROMIUM names '{named}', but '{program} --version' fails. Run that to see why."
        )
    return Path(program)


def _on_path(search_path: str) -> Path | str:
    for name in NAMES:
        program = shutil.which(name, path=search_path)
        if program is not None and starts(program):
            return Path(program)
    return f"no {', '.join(NAMES[:-1])} or {NAMES[-1]} that starts is on the PATH"


def _from_debian(search_path: str) -> Path | str:
    os_release = OS_RELEASE.read_text(encoding="utf-8") if OS_RELEASE.exists() else ""
    if reason := can_use_apt(os.geteuid(), search_path, os_release):
        return reason
    _say("installing Debian's chromium with apt-get")
    install = ["apt-get", "install", "--yes", "--no-install-recommends", "chromium"]
    quiet = {"DEBIAN_FRONTEND": "noninteractive", "PATH": search_path}
    if not (_works(["apt-get", "update"], quiet) and _works(install, quiet)):
        return "apt-get could not install it (its reason is above)"
    found = _on_path(search_path)
    return found if isinstance(found, Path) else "what apt-get installed does not start"


def _from_playwright(_search_path: str) -> Path | str:
    path = _playwright_path()
    if path is not None and starts(str(path)):
        return path
    _say("downloading Playwright's Chromium")
    if not _works([sys.executable, "-m", "playwright", "install", "chromium"], {}):
        return "Playwright could not download its own (its reason is above)"
    path = _playwright_path()
    if path is None or not starts(str(path)):
        return (
            "Playwright's own was downloaded but does not start, most likely for want of system "
            "libraries (as root: .venv/bin/playwright install-deps chromium)"
        )
    return path


def _playwright_path() -> Path | None:
    """Return where Playwright keeps, or would keep, its Chromium."""
    program = (
        "from playwright.sync_api import sync_playwright\n"
        "with sync_playwright() as p: print(p.chromium.executable_path)"
    )
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=False
    )
    return Path(done.stdout.strip()) if done.returncode == 0 and done.stdout.strip() else None


def _works(command: Sequence[str], environ: Mapping[str, str]) -> bool:
    try:
        done = subprocess.run(
            command, env={**os.environ, **environ}, stdout=sys.stderr, check=False
        )
    except OSError as error:
        _say(str(error))
        return False
    return done.returncode == 0


def _say(message: str) -> None:
    print(f"No Chromium found: {message}", file=sys.stderr)


def main() -> int:
    """Print the path of the browser to test in."""
    try:
        print(find_browser())
    except NoBrowser as error:
        print(f"Tril: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
