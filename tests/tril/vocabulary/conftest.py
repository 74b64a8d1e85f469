"""The vocabulary of drawn games, which most tests of this folder share."""

from __future__ import annotations

import numpy as np
import pytest

from tests.tril.vocabulary.test_facts import HORIZON, played
from tril.vocabulary.facts import Vocabulary


@pytest.fixture(scope="session")
def words() -> Vocabulary:
    background = np.zeros((210, 160), np.uint8)
    return Vocabulary.of_games([played(seed) for seed in range(20)], background, 2, HORIZON)
