"""How the learned reward judges games that it was not learned from.

T-REX (Brown et al. 2019, section 5 and figure 3) plots the predicted return against the true one
for the demonstrations and for trajectories that the learning has not seen, better ones among them.
"""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass
from typing import Literal

from tril.ranking import kendall_tau

Player = Literal["person", "demonstrator", "imitator", "clone"]


@dataclass(frozen=True)
class JudgedGame:
    """What a game was worth, and what the learned reward says of it.

    Attributes:
        true_quantity: See true_quantity.
        predicted_return: Sum of R over the game.
        recording_id: The recording of the game.
    """

    true_quantity: int
    predicted_return: float
    recording_id: int


@dataclass(frozen=True)
class JudgedGames:
    """The games of one who played, all demonstrations or all unseen.

    Attributes:
        player: Who played.
        demonstrated: Whether the reward was learned from them.
        games: The games.
    """

    player: Player
    demonstrated: bool
    games: tuple[JudgedGame, ...]

    @property
    def tau(self) -> float | None:
        """Kendall's tau-b between true quantity and predicted return, -1 to 1.

        None where all games are worth the same, so that there is no order to agree with.
        """
        tiers: dict[int, list[int]] = defaultdict(list)
        for index, game in enumerate(self.games):
            tiers[game.true_quantity].append(index)
        if len(tiers) < 2:
            return None
        best_first = [tiers[quantity] for quantity in sorted(tiers, reverse=True)]
        return kendall_tau(best_first, [game.predicted_return for game in self.games])


def true_quantity(targets: int, strays: int) -> int:
    """Return what a game is worth by the aliens shot: targets hit, less strays."""
    return targets - strays
