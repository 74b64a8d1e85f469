"""``tril`` commands as processes of their own."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
import threading
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import httpx2
import psutil

from server.main import bind
from testsupport.databases import settings_on
from testsupport.live import TIMEOUT_S, begin_game, cookie
from testsupport.waiting import wait_until
from tril.settings import Settings

COMMAND = (sys.executable, "-m", "cli")
SERVER_STARTED = "Application startup complete"


@dataclass
class TrilProcess:
    """A ``tril`` command that runs.

    Attributes:
        process: What was started.
        settings: Its settings.
        output: What it has printed, line by line.
    """

    process: subprocess.Popen[str]
    settings: Settings
    output: list[str] = field(default_factory=list)

    def wait_for(self, pattern: str, times: int = 1) -> str:
        """Wait until so many lines match a regular expression; returns what matched last."""

        def matches() -> list[str]:
            found = (re.search(pattern, line) for line in self.output)
            return [match.group() for match in found if match is not None]

        wait_until(
            lambda: len(matches()) >= times or self.process.poll() is not None,
            what_was_said=lambda: "".join(self.output),
        )
        found = matches()
        assert len(found) >= times, "".join(self.output)
        return found[-1]

    @property
    def address(self) -> str:
        """The page's address with its token, once ``tril up`` has printed it."""
        return self.wait_for(r"https?://\S+\?token=\S+")

    @property
    def pids(self) -> list[int]:
        """The processes that serve: the command's children, or it alone."""
        children = psutil.Process(self.process.pid).children()
        return [child.pid for child in children] or [self.process.pid]

    @property
    def base_url(self) -> str:
        """Where the server answers."""
        return f"http://127.0.0.1:{self.settings.port}"

    def http(self) -> httpx2.Client:
        """Return a client that is signed in; its connections stay with one server process."""
        return httpx2.Client(
            base_url=self.base_url,
            headers={"Cookie": cookie(self.settings)},
            timeout=TIMEOUT_S,
        )

    def new_game(self, **more: Any) -> dict[str, Any]:
        """Begin a game."""
        with self.http() as http:
            return begin_game(http, **more)

    def stop(self, number: signal.Signals = signal.SIGINT) -> int:
        """Send a signal and wait for the end; returns the exit status."""
        if self.process.poll() is None:
            self.process.send_signal(number)
        return self.process.wait(TIMEOUT_S)


@contextmanager
def tril_process(
    settings: Settings,
    *arguments: str,
    command: Sequence[str | Path] = COMMAND,
    environ: Mapping[str, str] = os.environ,
    cwd: Path | None = None,
) -> Iterator[TrilProcess]:
    """Run a command until the end of the block.

    Args:
        settings: What the command is told by its environment.
        *arguments: Of the command.
        command: How ``tril`` is called.
        environ: The environment without settings.
        cwd: The current folder of the command.
    """
    process = subprocess.Popen(
        [*command, *arguments],
        env=environment_of(settings, environ),
        cwd=cwd,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )
    running = TrilProcess(process, settings)
    reader = threading.Thread(target=_read, args=(running,), daemon=True)
    reader.start()
    try:
        yield running
    finally:
        try:
            running.stop(signal.SIGTERM)
        finally:
            process.kill()
            process.wait()
            reader.join(TIMEOUT_S)


def environment_of(settings: Settings, environ: Mapping[str, str] = os.environ) -> dict[str, str]:
    """Return the environment of a command that has these settings and no others."""
    chosen = settings.model_dump(exclude_defaults=True)
    return {
        **{name: value for name, value in environ.items() if not name.startswith("TRIL_")},
        **{f"TRIL_{name.upper()}": str(value) for name, value in chosen.items()},
        "COLUMNS": "200",
        "PYTHONUNBUFFERED": "1",
    }


def _read(running: TrilProcess) -> None:
    assert running.process.stdout is not None
    with running.process.stdout as lines:
        for line in lines:
            running.output.append(line)


@contextmanager
def server_process(
    data: Path, n_processes: int = 1, port: int = 0, **settings: Any
) -> Iterator[TrilProcess]:
    """Run ``tril serve`` and wait until every process answers.

    Args:
        data: A migrated data folder.
        n_processes: How many serve.
        port: Which port; 0 takes any free one.
        **settings: More settings by name.
    """
    with bind(settings_on(data, port=port)) as free:
        port = free.getsockname()[1]
    made = settings_on(data, port=port, server_processes=n_processes, **settings)
    with tril_process(made, "serve") as tril:
        tril.wait_for(SERVER_STARTED, n_processes)
        yield tril


@contextmanager
def whole_tril(data: Path, *arguments: str, **how: Any) -> Iterator[TrilProcess]:
    """Run ``tril up`` on a free port and wait until it prints its address.

    Args:
        data: The data folder; made if it is missing.
        *arguments: More arguments.
        **how: As for tril_process.
    """
    up = ("up", "--port", "0", "--no-browser", *arguments)
    # Behind the games, but not behind everything that the tests beside it do.
    with tril_process(settings_on(data, learning_niceness=10), *up, **how) as tril:
        port = urlsplit(tril.address).port
        tril.settings = tril.settings.model_copy(update={"port": port})
        yield tril
        assert tril.stop() == 0, "".join(tril.output[-60:])
