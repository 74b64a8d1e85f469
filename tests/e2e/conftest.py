"""A whole Tril (``tril up``) with a data folder of its own, and a real browser before it."""

from __future__ import annotations

import os
import queue
import re
import signal
import subprocess
import sys
import threading
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import pytest
from playwright.sync_api import Browser, Page, sync_playwright

from server.pages import FRONTEND
from tests.server.live import LiveServer, live_server
from tests.workplace import make_workplace

BROWSER_ARGUMENTS = [
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
]
ADDRESS = re.compile(r"http://\S+\?token=\S+")
START_TIMEOUT_S = 90


@dataclass
class RunningTril:
    """A started ``tril up``: its address with the token and everything it printed."""

    process: subprocess.Popen[str]
    data: Path
    address: str = ""
    output: list[str] = field(default_factory=list)

    def stop(self) -> int:
        """Press Ctrl-C and wait; returns the exit status."""
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGINT)
        return self.process.wait(30)


def start_tril(data: Path, *arguments: str) -> RunningTril:
    """Start ``tril up`` on a free port and wait until it prints its address."""
    environment = {k: v for k, v in os.environ.items() if not k.startswith("TRIL_")}
    process = subprocess.Popen(
        [sys.executable, "-m", "cli.main", "up", "--port", "0", "--no-browser", *arguments],
        env={**environment, "TRIL_DATA": str(data), "COLUMNS": "200", "PYTHONUNBUFFERED": "1"},
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        start_new_session=True,
    )
    running = RunningTril(process, data)
    addresses: queue.Queue[str] = queue.Queue()

    def _read() -> None:
        assert process.stdout is not None
        with process.stdout:
            for line in process.stdout:
                running.output.append(line)
                if found := ADDRESS.search(line):
                    addresses.put(found.group())

    threading.Thread(target=_read, daemon=True).start()
    try:
        running.address = addresses.get(timeout=START_TIMEOUT_S)
    except queue.Empty:
        running.stop()
        raise AssertionError("tril up printed no address:\n" + "".join(running.output)) from None
    return running


@pytest.fixture(scope="session")
def browser(chromium: Path) -> Iterator[Browser]:
    """Return a headless Chromium."""
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(
            executable_path=str(chromium),
            headless=True,
            chromium_sandbox=os.geteuid() != 0,
            args=BROWSER_ARGUMENTS,
        )
        yield browser
        browser.close()


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> Iterator[LiveServer]:
    """Return a running server with the built pages, and nothing else of a Tril."""
    made = make_workplace(tmp_path_factory.mktemp("playing") / "data")
    made.database.close()
    with live_server(made.settings.data, frontend=FRONTEND) as running:
        yield running


@pytest.fixture(scope="module")
def running_tril(tmp_path_factory: pytest.TempPathFactory) -> Iterator[RunningTril]:
    """Return a Tril that runs for the tests of one module."""
    running = start_tril(tmp_path_factory.mktemp("e2e") / "data")
    yield running
    status = running.stop()
    assert status == 0, "".join(running.output[-60:])


@pytest.fixture
def page(browser: Browser, running_tril: RunningTril) -> Iterator[Page]:
    """Return a signed-in page; errors in its console fail the test."""
    context = browser.new_context(viewport={"width": 1280, "height": 900})
    page = context.new_page()
    problems: list[str] = []
    page.on("pageerror", lambda error: problems.append(str(error)))
    page.on("console", lambda m: problems.append(m.text) if m.type == "error" else None)
    page.set_default_timeout(15_000)
    page.goto(running_tril.address)
    yield page
    context.close()
    assert not problems, problems
