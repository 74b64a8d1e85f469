"""What every part's tests share: a data folder of their own, the browser, and their order."""

from __future__ import annotations

import gc
import os
from collections.abc import Generator, Iterator
from pathlib import Path
from typing import TYPE_CHECKING

# Tests that run side by side share the cores; this counts when torch is imported, which is later.
if "PYTEST_XDIST_WORKER" in os.environ:
    os.environ.setdefault("OMP_NUM_THREADS", "1")

import pytest
from hypothesis import settings

from testsupport.databases import on_postgresql, settings_on
from testsupport.postgres import cluster
from tril.cores import core_count

if TYPE_CHECKING:
    from testsupport.workplace import Workplace

BROWSER_TESTS = Path(__file__).parent / "e2e"
BROWSER_TEST_TIMEOUT_S = 600


def pytest_ignore_collect(collection_path: Path, config: pytest.Config) -> bool | None:
    """Leave out what the chosen mark has none of: to import all tests takes seconds."""
    is_browsers = collection_path == BROWSER_TESTS
    if config.option.markexpr == "not e2e":
        return is_browsers or None
    is_beside = collection_path.parent == BROWSER_TESTS.parent and not is_browsers
    return (config.option.markexpr == "e2e" and is_beside) or None


@pytest.hookimpl(wrapper=True)
def pytest_collection() -> Generator[None, object, object]:
    """Keep imported objects out of garbage collections, an eighth of the server tests' time."""
    gc.disable()
    try:
        return (yield)
    finally:
        gc.collect()
        gc.freeze()
        gc.enable()
        gc.set_threshold(10_000)


@pytest.hookimpl(wrapper=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> Generator[None]:
    """Mark what needs a browser; of what is to be run, put it in the order that ends soonest."""
    if on_postgresql():
        # Before any process is started that needs its address.
        cluster()
    for item in items:
        if BROWSER_TESTS in item.path.parents:
            item.add_marker("e2e")
            if item.get_closest_marker("timeout") is None:
                item.add_marker(pytest.mark.timeout(BROWSER_TEST_TIMEOUT_S))
    yield
    # Last, since the browser's driver keeps an event loop in this thread.
    items.sort(key=lambda item: item.get_closest_marker("e2e") is not None)
    items[:] = lengthy_first(items, int(os.environ.get("PYTEST_XDIST_WORKER_COUNT", "1")))


def pytest_addoption(parser: pytest.Parser) -> None:
    """Let the tests run on another database."""
    parser.addoption(
        "--database",
        choices=("sqlite", "postgresql"),
        default="sqlite",
        help="the database of the tests' data folders; PostgreSQL's server is started for them",
    )


def pytest_configure(config: pytest.Config) -> None:
    """Tell the processes that tests start which database was chosen; prepare Hypothesis."""
    os.environ["TESTS_DATABASE"] = config.getoption("--database")
    # Beside other tests an example may take any time.
    settings.register_profile("tests", deadline=None)
    settings.load_profile("tests")


def lengthy_first(items: list[pytest.Item], n_processes: int) -> list[pytest.Item]:
    """Return the tests with the lengthy ones first in each of the parts that processes begin with.

    Begun last, one of them would run on alone while the other processes have nothing left to do.
    pytest-xdist's worksteal cuts the list into parts as equal as possible and shifts tests later.
    """
    lengthy = [item for item in items if item.get_closest_marker("lengthy") is not None]
    others = [item for item in items if item.get_closest_marker("lengthy") is None]
    ordered: list[pytest.Item] = []
    for process in range(n_processes):
        size = (len(items) - len(ordered)) // (n_processes - process)
        ordered += lengthy[process::n_processes]
        n_others = max(0, size - len(lengthy[process::n_processes]))
        ordered += others[:n_others]
        del others[:n_others]
    return [*ordered, *others]


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_auto_num_workers() -> int:
    """Say how many processes run tests: one more than cores, as tests wait half of their time."""
    return core_count() + 1


@pytest.fixture
def data_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return an empty data folder that TRIL_DATA names; other settings are at their defaults."""
    folder = tmp_path / "data"
    folder.mkdir(mode=0o700)
    for name in [name for name in os.environ if name.upper().startswith("TRIL_")]:
        monkeypatch.delenv(name)
    monkeypatch.setenv("TRIL_DATA", str(folder))
    # The tests beside a worker leave nothing to one that is nice.
    monkeypatch.setenv("TRIL_LEARNING_NICENESS", "0")
    if on_postgresql():
        monkeypatch.setenv("TRIL_DATABASE_URL", settings_on(folder).database_url)
    return folder


@pytest.fixture
def workplace(tmp_path: Path) -> Iterator[Workplace]:
    """Return a migrated data folder with four ranked recordings of column 1."""
    # Here, so that tests which need none of it don't wait for it.
    from testsupport.workplace import make_workplace

    made = make_workplace(tmp_path / "data")
    yield made
    made.database.close()
