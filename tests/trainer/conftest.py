"""What the tests of the worker share."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.trainer.worker_zygote import Zygote
from tests.workplace import Workplace, make_workplace
from tril.jobs import Jobs


@pytest.fixture(scope="session")
def zygote() -> Iterator[Zygote]:
    made = Zygote()
    yield made
    made.close()


@pytest.fixture
def workplace(tmp_path: Path) -> Iterator[Workplace]:
    made = make_workplace(tmp_path)
    yield made
    made.database.close()


@pytest.fixture
def jobs(workplace: Workplace) -> Iterator[Jobs]:
    made = Jobs(workplace.database, workplace.settings)
    yield made
    made.close()
