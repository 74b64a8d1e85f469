"""Made-up results."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from trainer.reporting.ledger import Entry, LedgerCell, LedgerDemonstration, LedgerGame
from tril.games.space_invaders.behaviours import BUILT_IN
from tril.recipes import FAST, Recipe

GRID = [(row, column) for row in range(6) for column in range(6)]


def game(
    behaviour: str, start: int, targets: int, strays: int, *, died: bool = False
) -> LedgerGame:
    """Make a game of so many hits; start 0 is not held out."""
    (target,) = (set(one.target or ()) for one in BUILT_IN if one.slug == behaviour)
    wanted = [cell for cell in GRID if cell in target]
    others = [cell for cell in GRID if cell not in target]
    hits = (*wanted[:targets], *others[:strays])
    return LedgerGame(start, start > 0, hits, 300, died, 12.5)


def entry(
    behaviour: str = "column-2",
    seed: int = 0,
    steps: int = 1000,
    recipe: Recipe = FAST,
    **values: Any,
) -> Entry:
    """Make a result in which each policy wins a start and one is a tie."""
    made = Entry(
        cell=LedgerCell.of(behaviour, recipe, steps, seed),
        finished_at="2026-01-02T03:04:05+00:00",
        seconds={"demonstrations": 600.0, "reward": 60.0, "imitator": 120.0},
        check={"tau": 1.0, "pair_accuracy": 0.99, "held_out_accuracy": 0.97},
        versions={"python": "3.11"},
        demonstrations=(
            LedgerDemonstration(1, ((0, 1), (1, 1)), 20.0),
            LedgerDemonstration(2, ((0, 0),), -3.0),
        ),
        games={
            "imitator greedy": (
                game(behaviour, 0, 6, 0),
                game(behaviour, 1, 5, 0),
                game(behaviour, 2, 2, 0, died=True),
            ),
            "clone greedy": (
                game(behaviour, 0, 6, 0),
                game(behaviour, 1, 5, 1),
                game(behaviour, 2, 3, 0),
            ),
        },
    )
    return replace(made, **values)
