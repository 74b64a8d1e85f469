"""How well the learned reward extrapolates to games that it was not learned from.

T-REX (Brown et al. 2019, section 5 and figure 3) plots the predicted return against the true one
for the demonstrations and for trajectories that the learning has not seen, better ones among them.
A sum of R grows with a game's length, so a game that is lost early is predicted less than it is
worth. Games are therefore judged by the level of R that they end at, as the ranking is checked.
"""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass
from typing import Literal

from tril.ranking import kendall_tau

PlayerKind = Literal["person", "demonstrator", "varied", "imitator", "clone"]

Measure = Literal["final_level", "predicted_return"]
"""What of R a game is judged by: the mean level of its last 25 states, or the sum of R over all."""


@dataclass(frozen=True)
class JudgedGame:
    """A game's true quantity (targets hit less strays), and what R makes of it by the measure."""

    true_quantity: int
    predicted: float
    recording_id: int


@dataclass(frozen=True)
class JudgedGames:
    """The games of one player, all demonstrations or all unseen by the reward model."""

    player: PlayerKind
    demonstrated: bool
    measure: Measure
    games: tuple[JudgedGame, ...]

    @property
    def tau(self) -> float | None:
        """Kendall's tau-b between true quantity and what R predicts, -1 to 1.

        None where all games have the same true quantity and so no order.
        """
        tiers: dict[int, list[int]] = defaultdict(list)
        for index, game in enumerate(self.games):
            tiers[game.true_quantity].append(index)
        if len(tiers) < 2:
            return None
        best_first = [tiers[quantity] for quantity in sorted(tiers, reverse=True)]
        return kendall_tau(best_first, [game.predicted for game in self.games])


def true_quantity(targets: int, strays: int) -> int:
    """Return the true quantity of a game: targets hit less strays."""
    return targets - strays
