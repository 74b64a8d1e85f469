"""The supervisor with real child processes."""

from __future__ import annotations

import contextlib
import os
import queue
import signal
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import psutil

from cli.supervision.supervisor import Child, Supervisor
from testsupport.waiting import wait_until

Lines = queue.Queue[tuple[str, str]]


def _python(code: str) -> list[str]:
    return [sys.executable, "-c", code]


@contextmanager
def _supervised(*children: Child, stop_timeout_s: float = 10.0) -> Iterator[tuple[Lines, str]]:
    lines: Lines = queue.Queue()
    supervisor = Supervisor(
        children, lambda name, line: lines.put((name, line)), stop_timeout_s=stop_timeout_s
    )
    supervisor.start()
    watcher = threading.Thread(target=supervisor.watch)
    watcher.start()
    try:
        yield lines, "watching"
    finally:
        supervisor.request_stop()
        watcher.join()
        supervisor.stop()


def _next(lines: Lines, name: str) -> str:
    while True:
        source, line = lines.get(timeout=20)
        if source == name:
            return line


def _is_alive(pid: int) -> bool:
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    return True


WAITING = "import os, signal; print(os.getpid(), flush=True); signal.pause()"


def test_a_killed_child_is_announced_and_started_again() -> None:
    with _supervised(Child("one", _python(WAITING))) as (lines, _):
        first = int(_next(lines, "one"))
        os.kill(first, signal.SIGKILL)
        assert _next(lines, "tril") == "one stopped (signal SIGKILL); it starts again in 1 s."
        second = int(_next(lines, "one"))
        assert second != first
    assert not _is_alive(second)


def test_the_delay_before_a_restart_doubles() -> None:
    with _supervised(Child("one", _python("raise SystemExit(3)"))) as (lines, _):
        assert _next(lines, "tril") == "one stopped (exit code 3); it starts again in 1 s."
        assert _next(lines, "tril") == "one started again."
        assert _next(lines, "tril") == "one stopped (exit code 3); it starts again in 2 s."


def test_stop_ends_children_that_ignore_the_request_and_what_they_left() -> None:
    stubborn = (
        "import signal, subprocess, sys, time\n"
        "signal.signal(signal.SIGTERM, signal.SIG_IGN)\n"
        "left = subprocess.Popen([sys.executable, '-c', 'import signal; signal.pause()'])\n"
        "print(left.pid, flush=True)\n"
        "while True: signal.pause()\n"
    )
    with _supervised(Child("one", _python(stubborn)), stop_timeout_s=0.5) as (lines, _):
        left = int(_next(lines, "one"))
    with contextlib.suppress(psutil.NoSuchProcess):
        psutil.Process(left).wait(10)
    assert not psutil.pid_exists(left)


FOLLOWING = """
import time
from cli.follow import worker_at_hand
from cli.workspace import open_workspace
with open_workspace() as workspace, worker_at_hand(workspace):
    time.sleep(600)
"""


def test_a_worker_started_for_one_command_ends_with_it_even_if_that_is_killed(
    data_folder: Path,
) -> None:
    command = subprocess.Popen(_python(FOLLOWING), stderr=subprocess.DEVNULL)
    log = data_folder / "logs" / "worker.log"
    try:
        wait_until(lambda: log.exists() and "waits for runs" in log.read_text(), 60.0)
        [worker] = psutil.Process(command.pid).children()
    finally:
        command.kill()
        command.wait()
    wait_until(lambda: not worker.is_running(), 30.0)
