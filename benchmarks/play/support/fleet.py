"""Measured server processes behind one port."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import psutil

from server.main import take_port
from server.play.hub import N_SPARE_CONSOLES
from server.play.lateness import Lateness
from testsupport.waiting import wait_until
from tril.settings import Settings

START_TIMEOUT_S = 120.0


@dataclass(frozen=True)
class Sample:
    """Totals of all servers since their start.

    Attributes:
        lateness: Lateness of all games' frames.
        watched: Lateness of watched games' frames; side by side they count as one game.
        cpu_s: CPU time.
        rss_bytes: Resident memory at present.
    """

    lateness: Lateness
    watched: Lateness
    cpu_s: float
    rss_bytes: int


@dataclass(frozen=True)
class Fleet:
    """Running server processes.

    Attributes:
        settings: Their settings, with the port.
        processes: The processes.
        measures: The file that each of them writes.
    """

    settings: Settings
    processes: list[psutil.Process]
    measures: list[Path]

    def sample(self) -> Sample:
        """Return the present totals."""
        lateness, watched, cpu_s, rss_bytes = Lateness(), Lateness(), 0.0, 0
        for process, written in zip(self.processes, self._ask(), strict=True):
            times = process.cpu_times()
            lateness += Lateness(written["late"])
            watched += Lateness(written["watched_late"])
            cpu_s += times.user + times.system
            rss_bytes += process.memory_info().rss
        return Sample(lateness, watched, cpu_s, rss_bytes)

    def has_consoles(self, n_each: int) -> bool:
        """Return whether every process has loaded at least so many consoles."""
        return all(written["consoles"] >= n_each for written in self._ask())

    def memory(self) -> list[dict[str, Any]]:
        """Return what each process holds, see ``memory_use``."""
        return [written["memory"] for written in self._ask()]

    def _ask(self) -> list[dict[str, Any]]:
        for path, process in zip(self.measures, self.processes, strict=True):
            path.unlink(missing_ok=True)
            process.send_signal(signal.SIGUSR1)
        for path in self.measures:
            wait_until(path.exists, START_TIMEOUT_S)
        return [json.loads(path.read_text()) for path in self.measures]


@contextmanager
def running_fleet(
    data: Path, n_processes: int, games_each: int, niceness: int = 0, trace_memory: bool = False
) -> Iterator[Fleet]:
    """Run server processes for the block, with all their consoles loaded.

    Args:
        data: A migrated data folder.
        n_processes: Number of processes.
        games_each: Most games in each.
        niceness: Their niceness; only root may choose a negative one.
        trace_memory: Whether they are to say which lines allocate, which makes them slower.
    """
    with ExitStack() as stack:
        held = stack.enter_context(take_port(Settings(data=data, port=0), shares_port=True))
        settings = Settings(data=data, port=held.getsockname()[1])
        processes, measures, logs = [], [], []
        for number in range(n_processes):
            measures.append(data / f"measures-{number}.json")
            logs.append(data / f"server-{number}.log")
            log = stack.enter_context(logs[-1].open("w"))
            arguments = {
                "--data": data,
                "--port": settings.port,
                "--measures": measures[-1],
                "--games": games_each,
                "--niceness": niceness,
            }
            command = [sys.executable, "-m", "benchmarks.play.support.measured_server"]
            command += ["--trace-memory"] * trace_memory
            words = [str(word) for pair in arguments.items() for word in pair]
            started = subprocess.Popen([*command, *words], stderr=log)
            stack.callback(_stop, started)
            processes.append(psutil.Process(started.pid))
        for log_file in logs:
            wait_until(partial(_has_started, log_file), START_TIMEOUT_S)
        fleet = Fleet(settings, processes, measures)
        n_consoles = games_each + N_SPARE_CONSOLES
        wait_until(lambda: fleet.has_consoles(n_consoles), START_TIMEOUT_S)
        yield fleet


def _has_started(log: Path) -> bool:
    return "startup complete" in log.read_text(encoding="utf-8")


def _stop(process: subprocess.Popen[bytes]) -> None:
    process.terminate()
    try:
        process.wait(30)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()
