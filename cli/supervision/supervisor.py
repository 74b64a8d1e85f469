"""Supervision of child processes: restart with backoff, forward output, stop."""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from cli.supervision.orphans import child_environment

MIN_BACKOFF_S = 1.0
MAX_BACKOFF_S = 30.0
STABLE_AFTER_S = 60.0
POLL_S = 0.1
INHERITED_TIMEOUT_S = 2.0


@dataclass(frozen=True)
class Child:
    """A process to run: its display name and command line."""

    name: str
    command: Sequence[str]


@dataclass
class _Running:
    child: Child
    process: subprocess.Popen[str] | None = None
    started_at: float = 0.0
    start_again_at: float = 0.0
    backoff_s: float = MIN_BACKOFF_S
    readers: list[threading.Thread] = field(default_factory=list)


class Supervisor:
    """Starts children and keeps them running until ``stop`` is called.

    A child that ends is restarted after a delay that doubles from 1 s to 30 s and is reset to 1 s
    once the child has run for a minute. Each child gets its own process group, so that Ctrl-C
    reaches only the supervisor, which stops children in reverse order.

    Args:
        children: Processes to run, in starting order.
        print_line: Called with a source and a line of output, its own messages included.
        environment: Variables added to this process's environment for the children.
        stop_timeout_s: Seconds after which a stopping child is killed.
    """

    def __init__(
        self,
        children: Sequence[Child],
        print_line: Callable[[str, str], None],
        environment: Mapping[str, str] | None = None,
        stop_timeout_s: float = 10.0,
    ) -> None:
        self._running = [_Running(child) for child in children]
        self._print_line = print_line
        self._environment = {
            **child_environment(),
            **(environment or {}),
            "PYTHONUNBUFFERED": "1",
        }
        self._stop_timeout_s = stop_timeout_s
        self._stopping = threading.Event()

    def start(self) -> None:
        """Start every child."""
        for running in self._running:
            self._start(running)

    def watch(self) -> None:
        """Restart children that end, until ``request_stop`` or ``stop`` is called."""
        while not self._stopping.wait(POLL_S):
            for running in self._running:
                self._restart_if_ended(running)

    def is_running(self, name: str) -> bool:
        """Return whether the named child is running."""
        return any(
            r.child.name == name and r.process is not None and r.process.poll() is None
            for r in self._running
        )

    def request_stop(self) -> None:
        """Make ``watch`` return. Safe in a signal handler."""
        self._stopping.set()

    @property
    def stop_requested(self) -> bool:
        """Whether a stop was requested."""
        return self._stopping.is_set()

    def stop(self) -> None:
        """Stop every child, last started first: SIGTERM, then SIGKILL after the timeout."""
        self._stopping.set()
        for running in reversed(self._running):
            if running.process is not None and running.process.poll() is None:
                running.process.terminate()
        deadline = time.monotonic() + self._stop_timeout_s
        for running in reversed(self._running):
            if running.process is None:
                continue
            try:
                running.process.wait(max(0.0, deadline - time.monotonic()))
            except subprocess.TimeoutExpired:
                self._print_line("tril", f"{running.child.name} did not stop in time; killing it.")
            self._kill_group(running.process)
            for reader in running.readers:
                reader.join(timeout=1.0)

    def _start(self, running: _Running) -> None:
        running.started_at = time.monotonic()
        running.process = subprocess.Popen(
            list(running.child.command),
            env=self._environment,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            encoding="utf-8",
            errors="replace",
            start_new_session=True,
        )
        reader = threading.Thread(
            target=self._forward_output, args=(running.child.name, running.process), daemon=True
        )
        reader.start()
        running.readers = [reader]

    def _forward_output(self, name: str, process: subprocess.Popen[str]) -> None:
        assert process.stdout is not None
        with process.stdout:
            for line in process.stdout:
                self._print_line(name, line.rstrip())

    def _restart_if_ended(self, running: _Running) -> None:
        process = running.process
        if process is not None:
            code = process.poll()
            if code is None:
                return
            if time.monotonic() - running.started_at > STABLE_AFTER_S:
                running.backoff_s = MIN_BACKOFF_S
            why = f"signal {signal.Signals(-code).name}" if code < 0 else f"exit code {code}"
            self._print_line(
                "tril",
                f"{running.child.name} stopped ({why}); restarting in {running.backoff_s:.0f} s.",
            )
            self._kill_group(process)
            running.process = None
            running.start_again_at = time.monotonic() + running.backoff_s
            running.backoff_s = min(MAX_BACKOFF_S, running.backoff_s * 2)
        elif time.monotonic() >= running.start_again_at:
            self._start(running)
            self._print_line("tril", f"{running.child.name} restarted.")

    @staticmethod
    def _kill_group(process: subprocess.Popen[str]) -> None:
        """Kill what is left of a child's process group, and wait for what this process inherits.

        It inherits what a child leaves where it is the first process of a container.
        """
        with contextlib.suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
        process.wait()
        deadline = time.monotonic() + INHERITED_TIMEOUT_S
        with contextlib.suppress(ChildProcessError):
            while time.monotonic() < deadline:
                if os.waitpid(-process.pid, os.WNOHANG)[0] == 0:
                    time.sleep(POLL_S)


@contextlib.contextmanager
def running(supervisor: Supervisor) -> Iterator[None]:
    """Run a supervisor's children for the duration of a block.

    SIGINT, SIGTERM and the end of the terminal (SIGHUP, unless it is ignored) make its ``watch``
    return.
    """

    def _on_signal(_number: int, _frame: Any) -> None:
        supervisor.request_stop()

    signal.signal(signal.SIGINT, _on_signal)
    signal.signal(signal.SIGTERM, _on_signal)
    # Not under nohup.
    if signal.getsignal(signal.SIGHUP) is not signal.SIG_IGN:
        signal.signal(signal.SIGHUP, _on_signal)
    try:
        supervisor.start()
        yield
    finally:
        supervisor.stop()


def numbered(name: str, n: int) -> list[str]:
    """Return the names of n children of a kind, numbered if there are several."""
    return [name] if n == 1 else [f"{name}-{i}" for i in range(1, n + 1)]


def tril_command(*arguments: str) -> list[str]:
    """Return the command line of a ``tril`` process run by this interpreter."""
    return [sys.executable, "-m", "cli", *arguments]
