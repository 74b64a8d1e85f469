"""Data folders and servers for the tests of the server."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from starlette.testclient import TestClient

from server.app import create_app
from server.security import Access
from tests.server.live import LiveServer, live_server
from tests.workplace import Workplace, make_workplace


@pytest.fixture
def workplace(tmp_path: Path) -> Iterator[Workplace]:
    """Return a migrated data folder with four ranked recordings of column 1."""
    made = make_workplace(tmp_path / "data")
    yield made
    made.database.close()


@pytest.fixture
def client(workplace: Workplace, frontend: Path) -> Iterator[TestClient]:
    """Return a client that is signed in."""
    app = create_app(workplace.settings, frontend)
    with TestClient(app, base_url=f"http://127.0.0.1:{workplace.settings.port}") as client:
        access = Access(workplace.settings)
        client.cookies.set(access.cookie_name, access.new_cookie())
        yield client


@pytest.fixture
def frontend(tmp_path: Path) -> Path:
    """Return the folder of a small built frontend."""
    folder = tmp_path / "dist"
    (folder / "assets").mkdir(parents=True)
    (folder / "index.html").write_text("<!doctype html><title>Tril</title>")
    (folder / "assets" / "index-abc123.js").write_text("export {}")
    (folder / "favicon.svg").write_text("<svg xmlns='http://www.w3.org/2000/svg'/>")
    (tmp_path / "secret.txt").write_text("not yours")
    return folder


@pytest.fixture(scope="module")
def live(tmp_path_factory: pytest.TempPathFactory) -> Iterator[LiveServer]:
    """Return a running server that a module's tests share."""
    made = make_workplace(tmp_path_factory.mktemp("live") / "data")
    made.database.close()
    with live_server(made.settings.data) as running:
        yield running
