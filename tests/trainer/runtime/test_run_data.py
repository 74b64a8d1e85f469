"""What a run learns from."""

from __future__ import annotations

from types import SimpleNamespace
from typing import cast

import pytest

from trainer.runtime.context import RunContext
from trainer.runtime.run_data import RunData
from tril.analysis.outcome import RunSnapshot
from tril.recipes import PAPER, Recipe, recipe_named

ANY = recipe_named("any", pretrained=False)


@pytest.mark.parametrize(
    ("recipe", "none_marked", "expected"),
    [(ANY, True, []), (ANY, False, [1]), (PAPER, True, [1])],
)
def test_best_ranked_games_that_stand_in_are_no_best_efforts_of_a_statement(
    recipe: Recipe, none_marked: bool, expected: list[int]
) -> None:
    snapshot = RunSnapshot(tiers=[[1], [2]], perfect=[1], none_marked=none_marked)
    context = SimpleNamespace(run=SimpleNamespace(snapshot=snapshot), recipe=recipe)
    assert RunData(cast("RunContext", context)).best_efforts == expected
