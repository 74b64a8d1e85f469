"""Tril behind nginx, configured as docs/operating.md says."""

from __future__ import annotations

import os
import re
import shutil
import socket
import ssl
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import httpx2
import pytest
from websockets.sync.client import connect
from websockets.typing import Origin

from server.main import bind
from server.web.security import address_with_token
from testsupport.browser import install_debian_packages
from testsupport.certificates import Certificate, has_openssl, make_certificate
from testsupport.live import TIMEOUT_S, begin_game, live_server
from testsupport.waiting import wait_until
from testsupport.workplace import Workplace
from tril.settings import Settings

DOCUMENTED = Path(__file__).resolve().parents[3] / "docs" / "operating.md"
NAME = "tril.example"

pytestmark = pytest.mark.lengthy


@pytest.fixture(scope="module")
def nginx() -> str:
    """Return the program; installed as root on Debian."""
    if not has_openssl():
        pytest.skip("needs the openssl program")
    path = f"{os.environ['PATH']}:/usr/sbin"
    if shutil.which("nginx", path=path) is None:
        install_debian_packages("nginx")
    found = shutil.which("nginx", path=path)
    if found is None:
        pytest.skip("needs nginx, which could not be installed")
    return found


def configuration(folder: Path, certificate: Certificate, port: int, upstream: int) -> str:
    """Return the documented configuration, with a test's files and ports."""
    (block,) = re.findall(r"```nginx\n(.*?)```", DOCUMENTED.read_text(), re.DOTALL)
    for before, after in (
        ("listen 443 ssl", f"listen 127.0.0.1:{port} ssl"),
        ("/etc/ssl/tril.example.pem", str(certificate.path)),
        ("/etc/ssl/private/tril.example.key", str(certificate.key)),
        ("127.0.0.1:8000", f"127.0.0.1:{upstream}"),
    ):
        assert before in block
        block = block.replace(before, after)
    temporary = "\n".join(
        f"{kind}_temp_path {folder}/{kind};"
        for kind in ("client_body", "proxy", "fastcgi", "uwsgi", "scgi")
    )
    user = "user root;" if os.geteuid() == 0 else ""
    return (
        f"daemon off; {user} pid {folder}/nginx.pid; error_log {folder}/error.log;\n"
        f"events {{}}\nhttp {{\n{temporary}\n{block}\n}}\n"
    )


@contextmanager
def running(nginx: str, folder: Path, config: str) -> Iterator[None]:
    (folder / "nginx.conf").write_text(config)
    process = subprocess.Popen(
        [nginx, "-p", folder, "-e", folder / "error.log", "-c", folder / "nginx.conf"]
    )
    try:
        wait_until(lambda: (folder / "nginx.pid").exists() or process.poll() is not None)
        assert process.poll() is None, (folder / "error.log").read_text()
        yield
    finally:
        process.terminate()
        process.wait(TIMEOUT_S)


def test_the_page_is_opened_and_played_through_nginx(
    nginx: str, workplace: Workplace, tmp_path: Path
) -> None:
    certificate = make_certificate(tmp_path, NAME)
    trusting = ssl.create_default_context(cafile=certificate.path)
    with bind(Settings(port=0)) as free:
        port = free.getsockname()[1]
    with live_server(
        workplace.settings.data, trusted_proxies="127.0.0.1", allowed_hosts=NAME
    ) as live:
        config = configuration(tmp_path, certificate, port, live.settings.port)
        origin = f"https://{NAME}:{port}"
        ours = {"Host": f"{NAME}:{port}", "Origin": origin}
        address = address_with_token(live.settings, f"https://127.0.0.1:{port}")
        with (
            running(nginx, tmp_path, config),
            httpx2.Client(
                base_url=f"https://127.0.0.1:{port}",
                verify=trusting,
                headers=ours,
                timeout=TIMEOUT_S,
            ) as http,
        ):
            cookie = http.get(address).headers["set-cookie"]
            assert "; secure" in cookie.lower()
            http.headers["Cookie"] = cookie.partition(";")[0]
            foreign = {"Origin": origin.replace("https", "http")}
            assert http.get("/api/player", headers=foreign).status_code == 403
            with http.stream("GET", "/api/events") as events:
                assert next(events.iter_lines()).startswith("retry"), "nothing waits in a buffer"
            game = begin_game(http)
            with connect(
                f"wss://{NAME}:{port}{game['stream_path']}",
                sock=socket.create_connection(("127.0.0.1", port), TIMEOUT_S),
                ssl=trusting,
                additional_headers={"Cookie": http.headers["Cookie"]},
                origin=Origin(origin),
                compression=None,
            ) as stream:
                assert '"hello"' in str(stream.recv(TIMEOUT_S))
