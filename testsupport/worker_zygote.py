"""Starts worker processes in no time: everything is imported once, then each worker is forked.

As a program it reads lines of JSON, ``{"data", "log", "lost_after_s", "settings"}``, forks a worker
for each and prints its process id. As a module it has the other end.
"""

from __future__ import annotations

import ctypes
import json
import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from testsupport.waiting import wait_until
from tril.jobs.delivery import LOST_AFTER_S

PR_SET_PDEATHSIG = 1


@dataclass(frozen=True)
class WorkerProcess:
    """A worker of its own process group."""

    pid: int
    log: Path

    def kill(self) -> None:
        """End the process by SIGKILL; what it started is left to notice by itself."""
        self.send(signal.SIGKILL)

    def send(self, number: signal.Signals) -> None:
        """Send a signal to the worker alone and wait until it is gone."""
        os.kill(self.pid, number)
        wait_until(lambda: not self.is_alive)

    @property
    def is_alive(self) -> bool:
        """Whether the process is there."""
        try:
            os.kill(self.pid, 0)
        except ProcessLookupError:
            return False
        return True


class Zygote:
    """Forks workers."""

    def __init__(self) -> None:
        self._process = subprocess.Popen(
            [sys.executable, "-m", "testsupport.worker_zygote"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        self._log_count = 0

    def start(
        self, data: Path, lost_after_s: float = LOST_AFTER_S, **settings: str
    ) -> WorkerProcess:
        """Start a worker for a data folder; it gives others up after ``lost_after_s``.

        Args:
            data: The data folder.
            lost_after_s: See run_worker.
            **settings: More settings by name.
        """
        self._log_count += 1
        log = data / f"worker-{self._log_count}.log"
        log.touch()
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        order = {
            "data": str(data),
            "log": str(log),
            "lost_after_s": lost_after_s,
            "settings": settings,
        }
        self._process.stdin.write(json.dumps(order) + "\n")
        self._process.stdin.flush()
        return WorkerProcess(int(self._process.stdout.readline()), log)

    @contextmanager
    def running(
        self, data: Path, lost_after_s: float = LOST_AFTER_S, **settings: str
    ) -> Iterator[WorkerProcess]:
        """A worker that is killed at the end of the block, unless it is gone."""
        worker = self.start(data, lost_after_s, **settings)
        try:
            yield worker
        finally:
            if worker.is_alive:
                worker.kill()

    def close(self) -> None:
        """End the zygote."""
        with self._process:
            assert self._process.stdin is not None
            self._process.stdin.close()


def _serve() -> None:
    # torch imports this with the first optimizer, which takes 1.5 s.
    import torch._dynamo  # noqa: F401

    from testsupport.databases import settings_on
    from trainer.runtime.worker import run_worker

    # Nobody waits for the workers: the kernel removes them at once.
    signal.signal(signal.SIGCHLD, signal.SIG_IGN)
    for line in sys.stdin:
        order = json.loads(line)
        pid = os.fork()
        if pid:
            print(pid, flush=True)
            continue
        signal.signal(signal.SIGCHLD, signal.SIG_DFL)
        os.setsid()
        # Should the tests be killed, the zygote ends, and with it every worker.
        ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGKILL)
        log = os.open(order["log"], os.O_WRONLY | os.O_APPEND)
        null = os.open(os.devnull, os.O_RDONLY)
        for descriptor, place in ((null, 0), (log, 1), (log, 2)):
            os.dup2(descriptor, place)
        try:
            # The tests beside a worker leave nothing to one that is nice.
            settings = settings_on(
                Path(order["data"]), learning_threads=1, learning_niceness=0, **order["settings"]
            )
            run_worker(settings, order["lost_after_s"])
        finally:
            sys.stdout.flush()
            os._exit(0)


if __name__ == "__main__":
    _serve()
