"""A PostgreSQL server of the tests' own: a socket in a temporary folder, no TCP, nothing synced."""

from __future__ import annotations

import atexit
import ctypes
import os
import pwd
import shutil
import signal
import subprocess
import tempfile
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import psycopg
from psycopg import sql

from testsupport.browser import install_debian_packages
from testsupport.waiting import wait_until

SERVER = "TESTS_POSTGRESQL"
"""Names the folder of the server's socket to the processes that tests start."""

ROLE = "tril"
INSTALLED = "/usr/lib/postgresql"
PR_SET_PDEATHSIG = 1

QUICK = {
    "listen_addresses": "",
    "fsync": "off",
    "full_page_writes": "off",
    "synchronous_commit": "off",
    "max_connections": "300",
    "autovacuum": "off",
}


@dataclass(frozen=True)
class Cluster:
    """A running server.

    Attributes:
        folder: Folder of its socket.
    """

    folder: Path

    def url(self, name: str) -> str:
        """Return the SQLAlchemy URL of a database."""
        return f"postgresql+psycopg://{ROLE}@/{name}?host={self.folder}"

    def create(self, name: str, template: str = "template0") -> None:
        """Create a database, as a copy of one that nobody is connected with."""
        statement = sql.SQL("CREATE DATABASE {} TEMPLATE {} STRATEGY FILE_COPY")
        self._execute(statement.format(sql.Identifier(name), sql.Identifier(template)))

    def has(self, name: str) -> bool:
        """Whether there is a database of this name."""
        with self._connect() as connection:
            found = connection.execute("SELECT 1 FROM pg_database WHERE datname = %s", (name,))
            return found.fetchone() is not None

    def drop(self, name: str) -> None:
        """Remove a database, with whoever is connected with it, if it is there."""
        statement = sql.SQL("DROP DATABASE IF EXISTS {} WITH (FORCE)")
        self._execute(statement.format(sql.Identifier(name)))

    def _execute(self, statement: sql.Composed) -> None:
        with self._connect() as connection:
            connection.execute(statement)

    def _connect(self) -> psycopg.Connection:
        return psycopg.connect(host=str(self.folder), user=ROLE, dbname="postgres", autocommit=True)


@cache
def cluster() -> Cluster:
    """Return the tests' server, which the first call starts; it ends with this process.

    Raises:
        RuntimeError: There is no PostgreSQL and none could be installed.
    """
    if SERVER in os.environ:
        return Cluster(Path(os.environ[SERVER]))
    folder = Path(tempfile.mkdtemp(prefix="tril-postgresql-"))
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    programs, data = prepare(folder)
    options = [f"--{name}={value}" for name, value in QUICK.items()]
    with (folder / "log").open("w") as log:
        server = subprocess.Popen(
            [programs / "postgres", "-D", data, "-k", folder, *options],
            user=owner(),
            cwd=folder,
            stdout=log,
            stderr=log,
            preexec_fn=end_with_parent,
        )
    atexit.register(_stop, server)
    os.environ[SERVER] = str(folder)
    made = Cluster(folder)
    wait_until(lambda: _answers(made), what_was_said=lambda: (folder / "log").read_text())
    return made


def prepare(folder: Path) -> tuple[Path, Path]:
    """Make the data of a server in a folder, which passes to the user who is to run it.

    Returns:
        The folder of the server's programs, and that of its data.

    Raises:
        RuntimeError: There is no PostgreSQL and none could be installed.
    """
    programs = find_or_install()
    if programs is None:
        raise RuntimeError(
            "These tests need the programs of a PostgreSQL server, initdb and postgres. Install "
            "it (Debian: apt install postgresql), or put its bin folder on the PATH."
        )
    user, data = owner(), folder / "data"
    if user is not None:
        shutil.chown(folder, user)
    initdb: list[str | Path] = [
        programs / "initdb",
        "--pgdata",
        data,
        "--username",
        ROLE,
        "--auth=trust",
    ]
    subprocess.run(
        [*initdb, "--no-sync", "--encoding=UTF8", "--locale=C"],
        user=user,
        cwd=folder,
        stdout=subprocess.DEVNULL,
        check=True,
    )
    return programs, data


def find_or_install() -> Path | None:
    """Return the folder of PostgreSQL's server programs; as root on Debian, install them first."""
    if (found := _find()) is None:
        install_debian_packages("postgresql")
        found = _find()
    return found


def _find() -> Path | None:
    if on_path := shutil.which("initdb"):
        return Path(on_path).resolve().parent
    versions = Path(INSTALLED).glob("[0-9]*/bin/initdb")
    newest = max(versions, key=lambda place: int(place.parts[-3]), default=None)
    return newest.parent if newest else None


def owner() -> str | None:
    """Return who is to run the server, which refuses to run as root; None for whoever this is."""
    if os.geteuid() != 0:
        return None
    known = {user.pw_name for user in pwd.getpwall()}
    return "postgres" if "postgres" in known else "nobody"


def end_with_parent() -> None:
    """Let a server that is being started shut down at once should the tests be killed."""
    ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGQUIT)


def _answers(server: Cluster) -> bool:
    try:
        return server.has("postgres")
    except psycopg.OperationalError:
        return False


def _stop(server: subprocess.Popen[bytes]) -> None:
    server.send_signal(signal.SIGQUIT)
    server.wait()
