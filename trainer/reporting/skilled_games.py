"""Games of players of growing skill, and how predicted returns follow what the games are worth."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Annotated, Literal, NamedTuple

from pydantic import PlainSerializer

from trainer.reporting.digests import recipe_digest
from tril.ranking import kendall_tau
from tril.recipes import Recipe

Rounded = Annotated[float, PlainSerializer(lambda value: round(value, 2))]
"""A number of which the ledger keeps two digits."""

Quantity = Literal["points", "shots"]
QUANTITIES: dict[Quantity, str] = {
    "points": "points of the aliens shot",
    "shots": "missiles fired",
}


@dataclass(frozen=True, order=True)
class Experiment:
    """Names one extrapolation experiment.

    Attributes:
        quantity: Quantity that ranks the games.
        recipe: Name of the recipe whose reward is learned.
        digest: Digest of the recipe's reward part, see recipe_digest; no other part matters.
        training_seed: Feeds every random choice.
    """

    quantity: Quantity
    recipe: str
    digest: str
    training_seed: int

    @classmethod
    def of(cls, quantity: Quantity, recipe: Recipe, training_seed: int) -> Experiment:
        """Name the experiment."""
        return cls(quantity, recipe.name, recipe_digest(recipe.reward), training_seed)

    @property
    def picture(self) -> str:
        """File name of its picture."""
        return f"extrapolation-{self.quantity}-{self.recipe}-{self.training_seed}-{self.digest}.png"


class SkilledGame(NamedTuple):
    """A game of a player of some skill.

    Attributes:
        checkpoint: Training steps of the player before it.
        true_quantity: Points, or missiles fired.
        predicted_return: Sum of R over the game.
        demonstrated: Whether the reward was learned from it.
    """

    checkpoint: int
    true_quantity: int
    predicted_return: Rounded
    demonstrated: bool


@dataclass(frozen=True)
class Extrapolation:
    """The result of an experiment: its demonstrations and all other games."""

    version: Literal[2] = field(default=2, kw_only=True)
    experiment: Experiment
    games: tuple[SkilledGame, ...]

    @property
    def demonstrations(self) -> tuple[SkilledGame, ...]:
        """The games that the reward was learned from."""
        return tuple(game for game in self.games if game.demonstrated)

    @property
    def unseen(self) -> tuple[SkilledGame, ...]:
        """The others that are worth no more than the best demonstration."""
        return tuple(g for g in self.games if not g.demonstrated and not self._is_beyond(g))

    @property
    def beyond(self) -> tuple[SkilledGame, ...]:
        """The others that are worth more than any demonstration."""
        return tuple(game for game in self.games if self._is_beyond(game))

    @property
    def predicted_above(self) -> int:
        """How many games beyond the demonstrations are also predicted above all of them."""
        highest = max(game.predicted_return for game in self.demonstrations)
        return sum(game.predicted_return > highest for game in self.beyond)

    def _is_beyond(self, game: SkilledGame) -> bool:
        return game.true_quantity > max(
            demonstration.true_quantity for demonstration in self.demonstrations
        )


def tau_of(games: Sequence[SkilledGame]) -> float | None:
    """Return Kendall's tau-b between true quantity and predicted return; None if all are equal."""
    tiers = tiers_by([game.true_quantity for game in games])
    if len(tiers) < 2:
        return None
    return kendall_tau(tiers, [game.predicted_return for game in games])


def tiers_by(worths: Sequence[float]) -> list[list[int]]:
    """Return the indices in tiers of equal worth, best first."""
    indices_by_worth: dict[float, list[int]] = defaultdict(list)
    for index, worth in enumerate(worths):
        indices_by_worth[worth].append(index)
    return [indices_by_worth[worth] for worth in sorted(indices_by_worth, reverse=True)]
