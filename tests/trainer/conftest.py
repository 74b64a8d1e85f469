"""What the tests of the worker share."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from testsupport.worker_zygote import Zygote
from testsupport.workplace import Workplace
from tril.jobs import Jobs


@pytest.fixture(scope="session")
def zygote() -> Iterator[Zygote]:
    made = Zygote()
    yield made
    made.close()


@pytest.fixture
def jobs(workplace: Workplace) -> Iterator[Jobs]:
    made = Jobs(workplace.database, workplace.settings)
    yield made
    made.close()
