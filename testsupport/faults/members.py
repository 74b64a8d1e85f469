"""The processes that faults happen to."""

from __future__ import annotations

import os
import signal
import subprocess
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path

import psutil
import psycopg

from testsupport.faults.clocks import Clock
from testsupport.postgres import ROLE, Cluster, owner, prepare
from testsupport.processes import COMMAND, environment_of
from testsupport.s3 import S3Server, command, installed
from testsupport.waiting import wait_until
from tril.settings import Settings

STOP_TIMEOUT_S = 40.0


@dataclass
class Member:
    """A process that is started again after each fault.

    Attributes:
        name: What it is called in faults.
        command: Its command line.
        environment: Its environment.
        log: Where it writes to.
        user: Who runs it; None for whoever this is.
        clock: Its clock, if that can be set wrong.
    """

    name: str
    command: Sequence[str | Path]
    environment: Mapping[str, str]
    log: Path
    user: str | None = None
    clock: Clock | None = None
    _process: subprocess.Popen[bytes] | None = field(default=None, init=False)

    @property
    def pid(self) -> int:
        """The process's id."""
        assert self._process is not None
        return self._process.pid

    @property
    def is_alive(self) -> bool:
        """Whether the process runs or is suspended."""
        return self._process is not None and self._process.poll() is None

    def start(self) -> None:
        """Start the process, unless it is alive."""
        if self.is_alive:
            return
        with self.log.open("ab") as log:
            self._process = subprocess.Popen(
                self.command,
                env=self.environment,
                stdin=subprocess.DEVNULL,
                stdout=log,
                stderr=log,
                user=self.user,
            )

    def kill(self) -> None:
        """End the process by SIGKILL; what it started is left to notice by itself."""
        self.send(signal.SIGKILL)
        assert self._process is not None
        self._process.wait()

    def send(self, number: signal.Signals) -> None:
        """Send a signal to the process alone."""
        assert self._process is not None
        self._process.send_signal(number)

    def family(self) -> list[psutil.Process]:
        """Return the process and what it has started."""
        process = psutil.Process(self.pid)
        return [process, *process.children(recursive=True)]

    def stop(self) -> bool:
        """Ask the process to end; returns whether it did by itself."""
        if not self.is_alive:
            return True
        self.send(signal.SIGCONT)
        self.send(signal.SIGTERM)
        assert self._process is not None
        try:
            self._process.wait(STOP_TIMEOUT_S)
        except subprocess.TimeoutExpired:
            self.kill()
            return False
        return True


def tril_member(
    name: str,
    settings: Settings,
    logs: Path,
    host: Sequence[str] = (),
    clock: Clock | None = None,
) -> Member:
    """Return a process of Tril, called as its command with a number after it.

    Args:
        name: Such as ``worker 1``.
        settings: Its settings.
        logs: Folder for its output.
        host: What its command line begins with.
        clock: Its clock, if that can be set wrong.
    """
    kind = name.partition(" ")[0]
    words = [*host, *COMMAND, {"server": "serve"}.get(kind, kind)]
    environment = environment_of(settings) | (clock.environment() if clock else {})
    return Member(name, words, environment, logs / f"{name}.log", clock=clock)


class StoreMember(Member):
    """An S3 server of the campaign's own; it forgets its objects when it ends.

    Args:
        folder: Folder for its output.
        address: Its address.
        port: Its port.
        host: What its command line begins with.

    Raises:
        RuntimeError: Its packages can be neither found nor installed.
    """

    def __init__(self, folder: Path, address: str, port: int, host: Sequence[str] = ()) -> None:
        packages = installed()
        if packages is None:
            raise RuntimeError("The packages of the S3 server can't be installed; use a folder.")
        environment = {**os.environ, "PYTHONPATH": str(packages)}
        words = [*host, *command(address, port)]
        super().__init__("store", words, environment, folder / "store.log")
        self.server = S3Server(f"http://{address}:{port}")

    def start(self) -> None:
        """Start the server and wait until it answers."""
        super().start()
        wait_until(self.server.answers, what_was_said=lambda: self.log.read_text()[-2000:])


class PostgresMember(Member):
    """A PostgreSQL server of the campaign's own, which keeps what it has acknowledged.

    Args:
        folder: Folder for its data and its socket.
        host: What its command line begins with.
        address: Its address; None for the socket alone.
    """

    def __init__(self, folder: Path, host: Sequence[str] = (), address: str | None = None) -> None:
        programs, data = prepare(folder)
        if address is not None:
            with (data / "pg_hba.conf").open("a") as rules:
                rules.write("host all all samenet trust\n")
        # In a namespace nobody but root may run anything, so it changes its user itself.
        user = owner()
        changed = ["setpriv", f"--reuid={user}", f"--regid={user}", "--clear-groups"]
        options = [f"--listen_addresses={address or ''}", "--max_connections=300"]
        super().__init__(
            "database",
            [
                *host,
                *(changed if host and user else []),
                programs / "postgres",
                "-D",
                data,
                "-k",
                folder,
                *options,
            ],
            dict(os.environ),
            folder.parent / "database.log",
            user=None if host else user,
        )
        self.cluster = Cluster(folder)

    def start(self) -> None:
        """Start the server and wait until it answers."""
        super().start()
        wait_until(self._answers, what_was_said=lambda: self.log.read_text()[-2000:])

    def _answers(self) -> bool:
        try:
            psycopg.connect(host=str(self.cluster.folder), user=ROLE, dbname="postgres").close()
        except psycopg.OperationalError:
            return False
        return True

    def kill(self) -> None:
        """End the server and every process of it by SIGKILL."""
        for process in self.family():
            with suppress(psutil.NoSuchProcess):
                process.kill()
        super().kill()
