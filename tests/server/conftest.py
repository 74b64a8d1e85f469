"""Data folders and servers for the tests of the server."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from starlette.testclient import TestClient

from server import services
from server.play.replays import ReplayProcess
from tests.server.clients import build_frontend, signed_in
from testsupport.live import LiveServer, live_server
from testsupport.workplace import Workplace, make_workplace


class SharedReplays(ReplayProcess):
    """One process for all servers of these tests: each would take a second to start its own."""

    def stop(self) -> None:
        """Leave it to those who come."""

    def end(self) -> None:
        super().stop()


@pytest.fixture(scope="session", autouse=True)
def _shared_replays() -> Iterator[None]:
    shared = SharedReplays()
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(services, "ReplayProcess", lambda: shared)
        yield
    shared.end()


@pytest.fixture
def client(workplace: Workplace, tmp_path: Path) -> Iterator[TestClient]:
    """Return a client that is signed in."""
    with signed_in(workplace, build_frontend(tmp_path)) as client:
        yield client


@pytest.fixture(scope="module")
def reader(tmp_path_factory: pytest.TempPathFactory) -> Iterator[TestClient]:
    """Return a client that a module's tests share, because they change nothing."""
    folder = tmp_path_factory.mktemp("reader")
    made = make_workplace(folder / "data")
    with signed_in(made, build_frontend(folder)) as client:
        yield client
    made.database.close()


@pytest.fixture(scope="module")
def live(tmp_path_factory: pytest.TempPathFactory) -> Iterator[LiveServer]:
    """Return a running server that a module's tests share."""
    made = make_workplace(tmp_path_factory.mktemp("live") / "data")
    made.database.close()
    with live_server(made.settings.data) as running:
        yield running
