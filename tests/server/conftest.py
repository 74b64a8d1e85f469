"""Data folders and servers for the tests of the server."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from starlette.testclient import TestClient

from server import services
from server.play.consoles import ConsolePool
from server.play.hub import N_SPARE_CONSOLES
from tests.server.clients import build_frontend, signed_in
from testsupport.live import QUICK, LiveServer, live_server
from testsupport.replays import shared_replays
from testsupport.workplace import Workplace, make_workplace


class SharedConsoles(ConsolePool):
    """One pool for all servers of these tests: each would load up to six consoles, 0.15 s each."""

    def start(self) -> None:
        """They are loaded already."""

    def stop(self) -> None:
        """Leave them to those who come."""

    def begin(self) -> None:
        super().start()

    def end(self) -> None:
        super().stop()


@pytest.fixture(scope="session", autouse=True)
def _shared_by_servers() -> Iterator[None]:
    consoles = SharedConsoles(QUICK.max_games + N_SPARE_CONSOLES)
    consoles.begin()
    with shared_replays(), pytest.MonkeyPatch.context() as patch:
        patch.setattr(services, "ConsolePool", lambda _n_ahead: consoles)
        yield
    consoles.end()


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
