"""How good games were by what they hit, and how a person who is sometimes wrong ranks them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from tril.behaviours import Behaviour, Cell, score
from tril.demonstrator.kinds import ExampleKind
from tril.demonstrator.manner import PERFECT
from tril.errors import Invalid
from tril.game.episode import EndReason
from tril.ranking import Pair, Ranking, agreement, contradictions, normalise


@dataclass(frozen=True)
class ShownGame:
    """What a demonstration turned out to show.

    Attributes:
        plan_number: Number of its plan, 1 being the best.
        hits: The aliens hit as (row, column), in order of time.
        end: Why it ended, None where it was left before.
    """

    plan_number: int
    hits: tuple[Cell, ...]
    end: EndReason | None


@dataclass(frozen=True)
class Judgement:
    """The order that games should have and the one that they are given.

    Attributes:
        true: By what the games show.
        given: What learning gets: the true order with mistakes in it.
    """

    true: Ranking
    given: Ranking

    @property
    def mistakes(self) -> list[Pair]:
        """The pairs (better, worse) that are ranked the other way round."""
        return contradictions(self.true, self.given)

    def to_dict(self) -> dict[str, Any]:
        """The judgement as data, with Kendall's tau-b between the two orders."""
        return {
            "true_tiers": [list(tier) for tier in self.true.tiers],
            "given_tiers": [list(tier) for tier in self.given.tiers],
            "mistakes": [list(pair) for pair in self.mistakes],
            "tau": agreement(self.true, self.given).tau,
        }


def judge(
    behaviour: Behaviour,
    kind: ExampleKind,
    games: Mapping[int, ShownGame],
    rng: np.random.Generator,
) -> Judgement:
    """Rank the games of an example as its kind has it.

    Flawless games are as good as their plans. Of others it counts what they hit: the targets less
    the strays, a target out of order being no better than a stray; of equals those are better that
    the player survived.

    Args:
        behaviour: What they show.
        kind: Their kind.
        games: The games by the ids to rank.
        rng: Where the mistakes come from.

    Raises:
        Invalid: There are too few tiers for the mistakes.
    """
    flawless = kind.manner == PERFECT
    tiers: dict[tuple[int, ...], list[int]] = {}
    for number, shown in games.items():
        merit = (-shown.plan_number,) if flawless else _merit(behaviour, shown)
        tiers.setdefault(merit, []).append(number)
    true = normalise(tiers[merit] for merit in sorted(tiers, reverse=True))
    return Judgement(true, swap_neighbours(true, kind.n_mistakes, rng))


def swap_neighbours(ranking: Ranking, n_pairs: int, rng: np.random.Generator) -> Ranking:
    """Swap pairs of games of neighbouring tiers.

    No tier takes part in two swaps, so that as many pairs are ranked the wrong way round as asked
    for; games that tied with one of a pair become its neighbours.

    Raises:
        Invalid: There are fewer tiers than twice the pairs.
    """
    tiers = [list(tier) for tier in ranking.tiers]
    n_tiers = len(tiers)
    if n_tiers < 2 * n_pairs:
        raise Invalid(f"Expected {2 * n_pairs} tiers for {n_pairs} swaps, got {n_tiers}.")
    # The places of disjoint pairs are as many numbers drawn from a row that is shorter by one for
    # each pair, moved on by the pairs before.
    drawn = np.sort(rng.choice(n_tiers - n_pairs, n_pairs, replace=False))
    for above in (drawn + np.arange(n_pairs)).tolist():
        one = int(rng.integers(len(tiers[above])))
        other = int(rng.integers(len(tiers[above + 1])))
        tiers[above][one], tiers[above + 1][other] = tiers[above + 1][other], tiers[above][one]
    return normalise(tiers)


def _merit(behaviour: Behaviour, shown: ShownGame) -> tuple[int, int]:
    found = score(behaviour, shown.hits)
    assert found is not None, "only behaviours with target cells have an example"
    worth = found.targets - 2 * found.order_errors - found.strays
    return worth, int(shown.end is not EndReason.HIT)
