"""The vocabulary of drawn games, which most tests of this folder share."""

from __future__ import annotations

import pytest

from tests.tril.vocabulary.test_facts import BUTTONS, HORIZON, SCENE, played
from tril.vocabulary.facts import Vocabulary


@pytest.fixture(scope="session")
def words() -> Vocabulary:
    return Vocabulary.of_games([played(seed) for seed in range(20)], SCENE, BUTTONS, HORIZON)
