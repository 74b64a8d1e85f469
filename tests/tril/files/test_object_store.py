"""Object stores that are away, slow, or refuse."""

from __future__ import annotations

import os
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from datetime import timedelta
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any

import pytest

from testsupport import s3
from testsupport.ports import free_port
from tril.files import artifact_store
from tril.files.artifact_store import ArtifactStore, ArtifactStoreUnavailable

OPERATIONS: dict[str, Callable[[ArtifactStore], object]] = {
    "put": lambda store: store.put("a/x", b"content"),
    "get": lambda store: store.get("a/x"),
    "exists": lambda store: store.exists("a/x"),
    "names": lambda store: store.names("a"),
    "remove": lambda store: store.remove("a/x"),
    "remove_folder": lambda store: store.remove_folder("a"),
}

DENIED = b"<Error><Code>AccessDenied</Code><Message>Access Denied</Message></Error>"


@pytest.fixture(autouse=True)
def quickly(monkeypatch: pytest.MonkeyPatch) -> None:
    """Give up a second or so later, and know no credentials but the tests' own."""
    options = artifact_store.S3_OPTIONS
    monkeypatch.setitem(options["client_options"], "timeout", "500ms")
    monkeypatch.setitem(
        options, "retry_config", {"max_retries": 1, "retry_timeout": timedelta(seconds=1)}
    )
    for name in [name for name in os.environ if name.startswith("AWS_")]:
        monkeypatch.delenv(name)
    for name in ("AWS_ACCESS_KEY_ID", "AWS_SECRET_ACCESS_KEY"):
        monkeypatch.setenv(name, "tests")


@contextmanager
def answering(status: int, after_s: float = 0.0) -> Iterator[str]:
    """Serve one answer to every request; yields the URL."""
    ended = threading.Event()

    class Answer(BaseHTTPRequestHandler):
        def answer(self) -> None:
            self.rfile.read(int(self.headers.get("Content-Length", 0)))
            if ended.wait(after_s):
                return
            self.send_response(status)
            self.send_header("Content-Length", str(len(DENIED)))
            self.end_headers()
            if self.command != "HEAD":
                self.wfile.write(DENIED)

        def log_message(self, *_: Any) -> None:
            """Stay silent."""

    for method in ("GET", "HEAD", "PUT", "POST", "DELETE"):
        setattr(Answer, f"do_{method}", Answer.answer)
    with ThreadingHTTPServer(("127.0.0.1", 0), Answer) as server:
        server.daemon_threads = True
        thread = threading.Thread(target=server.serve_forever)
        thread.start()
        try:
            yield f"http://127.0.0.1:{server.server_port}"
        finally:
            ended.set()
            server.shutdown()
            thread.join()


def refusal(operation: str) -> str:
    with pytest.raises(ArtifactStoreUnavailable) as raised:
        OPERATIONS[operation](ArtifactStore("s3://bucket/prefix"))
    said = str(raised.value)
    assert "Debug" not in said
    assert "\n" not in said
    return said


@pytest.mark.parametrize("operation", OPERATIONS)
def test_a_store_that_fails_is_away_and_not_empty(
    operation: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    with answering(500) as url:
        monkeypatch.setenv("AWS_ENDPOINT_URL", url)
        assert "500" in refusal(operation)


@pytest.mark.parametrize("operation", OPERATIONS)
def test_a_store_that_refuses_the_key_says_so(
    operation: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    with answering(403) as url:
        monkeypatch.setenv("AWS_ENDPOINT_URL", url)
        assert "refuses the credentials" in refusal(operation)


@pytest.mark.parametrize("operation", ["put", "get", "names"])
def test_a_store_that_hangs_is_given_up(operation: str, monkeypatch: pytest.MonkeyPatch) -> None:
    with answering(200, after_s=60.0) as url:
        monkeypatch.setenv("AWS_ENDPOINT_URL", url)
        begun_at = time.monotonic()
        refusal(operation)
        assert time.monotonic() - begun_at < 20.0


def test_a_store_that_nobody_serves_is_away(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("AWS_ENDPOINT_URL", f"http://127.0.0.1:{free_port()}")
    for operation in OPERATIONS:
        assert "error sending request" in refusal(operation)


def test_missing_credentials_are_named(monkeypatch: pytest.MonkeyPatch) -> None:
    # Without any, the library asks the machine's provider, by an address that has none here.
    monkeypatch.delenv("AWS_ACCESS_KEY_ID")
    monkeypatch.delenv("AWS_SECRET_ACCESS_KEY")
    monkeypatch.setenv("AWS_ENDPOINT_URL", f"http://127.0.0.1:{free_port()}")
    assert "Set AWS_ACCESS_KEY_ID" in refusal("get")


def test_a_missing_bucket_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    s3.use(monkeypatch)
    for operation in ("put", "get", "names"):
        assert "no such bucket" in refusal(operation)


def test_a_folder_that_is_no_folder_is_away(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(ArtifactStoreUnavailable):
        ArtifactStore(str(tmp_path / "file")).put("a/x", b"")
