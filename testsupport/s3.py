"""An S3 server of the tests' own, moto, which keeps its objects in memory."""

from __future__ import annotations

import atexit
import fcntl
import hashlib
import os
import secrets
import shutil
import subprocess
import sys
import tempfile
import urllib.error
import urllib.request
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import pytest

from testsupport.ports import free_port
from testsupport.postgres import end_with_parent
from testsupport.waiting import wait_until

PACKAGES = Path(__file__).with_name("s3_server.txt")
INSTALL_TIMEOUT_S = 180
SERVE = "import sys; from moto.server import main; main(sys.argv[1:])"


@dataclass(frozen=True)
class S3Server:
    """A running server.

    Attributes:
        endpoint: Its URL.
    """

    endpoint: str

    def new_bucket(self) -> str:
        """Return the URL of an empty bucket."""
        name = f"tril-{secrets.token_hex(6)}"
        request = urllib.request.Request(f"{self.endpoint}/{name}", method="PUT")
        urllib.request.urlopen(request, timeout=10).close()
        return f"s3://{name}"

    def answers(self) -> bool:
        """Whether it can be reached."""
        try:
            urllib.request.urlopen(self.endpoint, timeout=1).close()
        except urllib.error.HTTPError:
            return True
        except OSError:
            return False
        return True

    def environment(self) -> dict[str, str]:
        """Return the environment variables by which a process reaches it."""
        return {
            "AWS_ENDPOINT_URL": self.endpoint,
            "AWS_ACCESS_KEY_ID": "tests",
            "AWS_SECRET_ACCESS_KEY": "tests",
            "AWS_REGION": "us-east-1",
        }


def use(patch: pytest.MonkeyPatch) -> S3Server:
    """Let this process and those that it starts find the server; returns it.

    The test is skipped where the server's packages can be neither found nor installed.
    """
    server = _running()
    if server is None:
        pytest.skip(f"needs the packages of {PACKAGES.name}, which can't be installed")
    for name, value in server.environment().items():
        patch.setenv(name, value)
    return server


@cache
def _running() -> S3Server | None:
    """Start the server with the first call; it ends with this process."""
    packages = installed()
    if packages is None:
        return None
    port = free_port()
    folder = Path(tempfile.mkdtemp(prefix="tril-s3-"))
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    with (folder / "log").open("w") as log:
        server = subprocess.Popen(
            command("127.0.0.1", port),
            env={**os.environ, "PYTHONPATH": str(packages)},
            cwd=folder,
            stdout=log,
            stderr=log,
            preexec_fn=end_with_parent,
        )
    atexit.register(server.kill)
    made = S3Server(f"http://127.0.0.1:{port}")
    wait_until(made.answers, what_was_said=lambda: (folder / "log").read_text())
    return made


def command(host: str, port: int) -> list[str]:
    """Return the command line of a server, whose PYTHONPATH has what was ``installed``."""
    return [sys.executable, "-c", SERVE, "--host", host, "--port", str(port)]


def installed() -> Path | None:
    """Return the folder of the server's packages, in the environment; install them if need be."""
    digest = hashlib.sha256(PACKAGES.read_bytes()).hexdigest()[:12]
    folder = Path(sys.prefix) / f"s3-server-{digest}"
    with Path(sys.prefix, "s3-server.lock").open("a", encoding="utf-8") as lock:
        # Tests that run side by side wait for the first.
        fcntl.lockf(lock, fcntl.LOCK_EX)
        if folder.is_dir():
            return folder
        for earlier in Path(sys.prefix).glob("s3-server-*"):
            shutil.rmtree(earlier, ignore_errors=True)
        whole = folder.with_name(f"{folder.name}.new")
        pip = [sys.executable, "-m", "pip", "--disable-pip-version-check", "install", "--quiet"]
        where = ["--no-deps", "--target", str(whole), "--requirement", str(PACKAGES)]
        try:
            subprocess.run([*pip, *where], check=True, timeout=INSTALL_TIMEOUT_S, stdout=sys.stderr)
        except (subprocess.SubprocessError, OSError):
            shutil.rmtree(whole, ignore_errors=True)
            return None
        whole.rename(folder)
    return folder
