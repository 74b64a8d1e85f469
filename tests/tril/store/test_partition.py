"""A host that is cut off from PostgreSQL: connections break, and nothing waits for ever."""

from __future__ import annotations

import shutil
import tempfile
import threading
from collections.abc import Iterator
from pathlib import Path

import pytest
from sqlalchemy import text
from sqlalchemy.exc import OperationalError

from testsupport.faults.members import PostgresMember
from testsupport.faults.network import MAIN, Network
from testsupport.postgres import ROLE
from tril.store import database as databases
from tril.store.database import create_database, is_unreachable

QUICK = {"keepalives_idle": "1", "keepalives_interval": "1", "tcp_user_timeout": "3000"}
PATIENCE_S = 30.0


@pytest.fixture
def network() -> Iterator[Network]:
    if not Network.is_possible():
        pytest.skip("Making hosts of its own needs root and `ip`.")
    made = Network((MAIN, "database"))
    try:
        made.open()
        yield made
    finally:
        made.close()


@pytest.fixture
def server(network: Network) -> Iterator[PostgresMember]:
    folder = Path(tempfile.mkdtemp(prefix="tril-partition-"))
    folder.chmod(0o755)  # the server runs as another user
    place = folder / "postgresql"
    place.mkdir()
    made = PostgresMember(place, network.command("database"), network.address("database"))
    made.start()
    yield made
    made.kill()  # stopped, it would wait for what is still asked
    shutil.rmtree(folder)


def test_who_waits_for_an_answer_that_was_lost_is_told(
    network: Network, server: PostgresMember, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(databases, "KEEPALIVES", {**databases.KEEPALIVES, **QUICK})
    address = network.address("database")
    database = create_database(f"postgresql+psycopg://{ROLE}@{address}/postgres")
    found: list[BaseException] = []
    is_asking = threading.Event()

    def ask() -> None:
        with database.reading() as session:
            session.execute(text("SELECT 1"))
            is_asking.set()
            try:
                session.execute(text("SELECT pg_sleep(20)"))
            except OperationalError as problem:
                found.append(problem)

    asking = threading.Thread(target=ask, daemon=True)
    asking.start()
    assert is_asking.wait(PATIENCE_S)
    asking.join(1.0)  # the question has arrived
    network.cut("database")
    asking.join(PATIENCE_S)
    (problem,) = found
    assert isinstance(problem, OperationalError)
    assert is_unreachable(problem)
    network.join("database")
    with database.reading() as session:
        assert session.scalar(text("SELECT 1")) == 1
    database.close()
