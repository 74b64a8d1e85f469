"""The supervisor with real child processes."""

from __future__ import annotations

import contextlib
import ctypes
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
import pytest

from cli.supervision.supervisor import Child, Supervisor, running
from cli.workspace import migrate_databases
from testsupport.waiting import PATIENCE_S, wait_until
from tril.settings import Settings

PR_SET_CHILD_SUBREAPER = 36

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


def test_the_first_process_of_a_container_waits_for_what_a_child_leaves() -> None:
    # A process that inherits orphans, as the first of a container does.
    libc = ctypes.CDLL(None)
    assert libc.prctl(PR_SET_CHILD_SUBREAPER, 1) == 0
    try:
        code = (
            "import subprocess, sys; orphan = subprocess.Popen(['sleep', '600']);"
            "print(orphan.pid, flush=True); sys.stdin.read()"
        )
        with _supervised(Child("child", _python(code))) as (lines, _):
            orphan = int(_next(lines, "child"))
            wait_until(lambda: not psutil.pid_exists(orphan))
    finally:
        libc.prctl(PR_SET_CHILD_SUBREAPER, 0)


@pytest.mark.parametrize("handler", [signal.SIG_DFL, signal.SIG_IGN])
def test_the_end_of_the_terminal_stops_everything_unless_it_is_ignored(
    handler: signal.Handlers,
) -> None:
    before = {
        number: signal.getsignal(number)
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
    }
    signal.signal(signal.SIGHUP, handler)
    supervisor = Supervisor([Child("child", _python("import time; time.sleep(600)"))], print)
    try:
        with running(supervisor):
            os.kill(os.getpid(), signal.SIGHUP)
            assert supervisor.stop_requested == (handler is signal.SIG_DFL)
    finally:
        for number, earlier in before.items():
            signal.signal(number, earlier)


def _next(lines: Lines, name: str) -> str:
    while True:
        source, line = lines.get(timeout=PATIENCE_S)
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
        assert _next(lines, "tril") == "one stopped (signal SIGKILL); restarting in 1 s."
        second = int(_next(lines, "one"))
        assert second != first
    assert not _is_alive(second)


def test_the_delay_before_a_restart_doubles() -> None:
    with _supervised(Child("one", _python("raise SystemExit(3)"))) as (lines, _):
        assert _next(lines, "tril") == "one stopped (exit code 3); restarting in 1 s."
        assert _next(lines, "tril") == "one restarted."
        assert _next(lines, "tril") == "one stopped (exit code 3); restarting in 2 s."


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
        psutil.Process(left).wait(PATIENCE_S)
    assert not psutil.pid_exists(left)


STARTS_AND_DIES = """
import os, signal, time
from cli.supervision.supervisor import Child, Supervisor, tril_command
supervisor = Supervisor([Child("worker", tril_command("worker"))], lambda *_: None)
supervisor.start()
print(supervisor._running[0].process.pid, flush=True)
os.kill(os.getpid(), signal.SIGKILL)
"""


def test_a_child_ends_when_its_supervisor_is_killed_before_the_child_has_imported_anything(
    data_folder: Path,
) -> None:
    migrate_databases(Settings())  # without it the worker ends by itself
    assert data_folder.exists()
    done = subprocess.run(_python(STARTS_AND_DIES), stdout=subprocess.PIPE, text=True)
    child = int(done.stdout)
    wait_until(lambda: not _is_alive(child))


GRANDCHILD = (
    "import os; from cli.supervision.orphans import PARENT_VARIABLE, exit_with_parent\n"
    "exit_with_parent(); print(PARENT_VARIABLE in os.environ, flush=True)"
)


def test_children_of_a_child_do_not_take_the_supervisor_for_their_parent() -> None:
    with _supervised(Child("one", _python(GRANDCHILD))) as (lines, _):
        assert _next(lines, "one") == "False"
