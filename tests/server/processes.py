"""Server processes of their own, as ``tril serve`` runs them."""

from __future__ import annotations

import os
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import httpx2
import psutil

from server.main import bind
from tests.server.live import TIMEOUT_S, cookie
from tril.settings import Settings

STARTED = "Application startup complete"
START_TIMEOUT_S = 60.0


@dataclass
class ServerProcess:
    """``tril serve``: one process, or a supervisor of several.

    Attributes:
        process: What was started.
        settings: Its settings, with the port it has.
        said: Its standard error, line by line.
    """

    process: subprocess.Popen[str]
    settings: Settings
    said: list[str] = field(default_factory=list)

    @property
    def base_url(self) -> str:
        """Where it answers."""
        return f"http://127.0.0.1:{self.settings.port}"

    def http(self) -> httpx2.Client:
        """Return a client that is signed in; its connections stay with one process."""
        headers = {"Cookie": cookie(self.settings)}
        return httpx2.Client(base_url=self.base_url, headers=headers, timeout=TIMEOUT_S)

    def new_game(self, **more: Any) -> dict[str, Any]:
        """Begin a game."""
        with self.http() as http:
            answer = http.post("/api/games", json={"behaviour_id": 1, **more})
        assert answer.status_code == 201, answer.text
        game: dict[str, Any] = answer.json()
        return game

    def pids(self) -> list[int]:
        """Return the processes that serve."""
        children = psutil.Process(self.process.pid).children()
        return [child.pid for child in children] or [self.process.pid]

    def wait_for(self, text: str, times: int = 1) -> None:
        """Wait until it has said something so often."""
        give_up_at = time.monotonic() + START_TIMEOUT_S
        while sum(text in line for line in self.said) < times:
            ended = self.process.poll() is not None
            if ended or time.monotonic() > give_up_at:
                raise AssertionError(f"The server never said {text!r}:\n" + "".join(self.said))
            time.sleep(0.02)


@contextmanager
def server_process(
    data: Path, n_processes: int = 1, port: int = 0, **settings: Any
) -> Iterator[ServerProcess]:
    """Run ``tril serve`` and wait until every process answers.

    Args:
        data: A migrated data folder.
        n_processes: How many serve.
        port: Which port; 0 takes any free one.
        **settings: More settings by name.
    """
    with bind(Settings(data=data, port=port)) as free:
        port = free.getsockname()[1]
    made = Settings(data=data, port=port, server_processes=n_processes, **settings)
    environment = {key: value for key, value in os.environ.items() if not key.startswith("TRIL_")}
    chosen = made.model_dump(exclude_defaults=True)
    environment |= {f"TRIL_{key.upper()}": str(value) for key, value in chosen.items()}
    # The lines of several processes come through their supervisor's standard output.
    process = subprocess.Popen(
        [sys.executable, "-m", "cli.main", "serve"],
        env={**environment, "COLUMNS": "200"},
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )
    server = ServerProcess(process, made)
    reader = threading.Thread(target=_read, args=(server,), daemon=True)
    reader.start()
    try:
        server.wait_for(STARTED, n_processes)
        yield server
    finally:
        process.terminate()
        try:
            process.wait(TIMEOUT_S)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
            raise
        finally:
            reader.join(TIMEOUT_S)


def _read(server: ServerProcess) -> None:
    assert server.process.stdout is not None
    with server.process.stdout as lines:
        for line in lines:
            server.said.append(line)
