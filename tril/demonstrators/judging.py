"""Rank an example's games by their outcomes, with simulated ranking mistakes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from tril.demonstrators.error_model import PERFECT
from tril.demonstrators.kinds import ExampleKind
from tril.errors import Invalid
from tril.games.base import Cell
from tril.games.behaviours import Behaviour, score
from tril.games.space_invaders.ends import EndReason
from tril.ranking import Pair, Ranking, contradictions, normalise, ranking_tau

_MISTAKES_STREAM = 3
"""Seeds the ranking mistakes independently of the games of the same seed."""


@dataclass(frozen=True)
class PlannedGame:
    """The outcome of a game that was played to a plan.

    Attributes:
        plan_number: Number of its plan, 1 being the best.
        hits: The items taken as (row, column), in order of time.
        end: Why it ended, None if it was quit.
    """

    plan_number: int
    hits: tuple[Cell, ...]
    end: str | None


@dataclass(frozen=True)
class Judgement:
    """The correct ranking of games and the one used for training.

    Attributes:
        true: Ranking by the games' outcomes.
        given: The true ranking with mistakes.
    """

    true: Ranking
    given: Ranking

    @property
    def mistakes(self) -> list[Pair]:
        """The pairs (better, worse) that the given ranking inverts."""
        return contradictions(self.true, self.given)

    def to_dict(self) -> dict[str, Any]:
        """Return both rankings, the mistakes, and Kendall's tau-b between the rankings."""
        return {
            "true_tiers": [list(tier) for tier in self.true.tiers],
            "given_tiers": [list(tier) for tier in self.given.tiers],
            "mistakes": [list(pair) for pair in self.mistakes],
            "tau": ranking_tau(self.true, self.given),
        }


def rank_example(
    behaviour: Behaviour,
    kind: ExampleKind,
    games: Mapping[int, PlannedGame],
    example_seed: int,
) -> Judgement:
    """Rank the games of an example and add the mistakes of its kind.

    Flawless games rank by plan number. Others rank by targets less strays, an out-of-order target
    counting as a stray; ties go to the games that the player survived.

    Args:
        behaviour: The behaviour shown.
        kind: The kind of example.
        games: The games by id.
        example_seed: Seed of the ranking mistakes.

    Raises:
        Invalid: There are too few tiers for the mistakes.
    """
    flawless = kind.error_model == PERFECT
    tiers: dict[tuple[int, ...], list[int]] = {}
    for number, game in games.items():
        plan = (-game.plan_number,)
        worth = plan if flawless else merit(behaviour, game.hits, game.end)
        tiers.setdefault(worth, []).append(number)
    true = normalise(tiers[worth] for worth in sorted(tiers, reverse=True))
    rng = np.random.default_rng([_MISTAKES_STREAM, example_seed])
    return Judgement(true, swap_neighbours(true, kind.n_mistakes, rng))


def swap_neighbours(ranking: Ranking, n_pairs: int, rng: np.random.Generator) -> Ranking:
    """Swap pairs of games in adjacent tiers.

    No tier takes part in two swaps, so exactly n_pairs pairs are inverted; a game tied with one of
    a pair ends up in the adjacent tier.

    Raises:
        Invalid: There are fewer than 2 * n_pairs tiers.
    """
    tiers = [list(tier) for tier in ranking.tiers]
    n_tiers = len(tiers)
    if n_tiers < 2 * n_pairs:
        raise Invalid(f"Expected {2 * n_pairs} tiers for {n_pairs} swaps, got {n_tiers}.")
    # Disjoint adjacent pairs: draw positions from a range shorter by one per pair, then shift each
    # by the number of pairs before it.
    drawn = np.sort(rng.choice(n_tiers - n_pairs, n_pairs, replace=False))
    for above in (drawn + np.arange(n_pairs)).tolist():
        index = int(rng.integers(len(tiers[above])))
        index_below = int(rng.integers(len(tiers[above + 1])))
        tiers[above][index], tiers[above + 1][index_below] = (
            tiers[above + 1][index_below],
            tiers[above][index],
        )
    return normalise(tiers)


def merit(behaviour: Behaviour, hits: tuple[Cell, ...], end: str | None) -> tuple[int, int]:
    """Return the merit of a game, for comparison: its hits, then whether it was survived.

    Args:
        behaviour: A behaviour with target cells.
        hits: The items taken as (row, column), in order of time.
        end: Why the game ended, None if it was quit.
    """
    outcome = score(behaviour, hits)
    assert outcome is not None, "only behaviours with target cells have an example"
    return outcome.worth, int(end != EndReason.HIT)
