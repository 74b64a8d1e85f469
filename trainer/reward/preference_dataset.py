"""What a reward model is learned from: games, and which of two is the better one."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np
import numpy.typing as npt

from trainer.reward.fragments import FragmentRule, FragmentStarts, preference_pairs
from trainer.reward.perturbation import PerturbedDemonstration
from tril.ranking import Pair
from tril.recipes import RewardRecipe
from tril.recording import Trajectory

T = TypeVar("T")

PERFECT_PER_UPDATE = 6
"""Perfect games that one update looks at; all of them would make it twice as slow."""

COPIES_PER_PERFECT = 2
"""Perturbed demonstrations of each of these that one update looks at."""


@dataclass(frozen=True)
class Game:
    """What can be seen of a game.

    Attributes:
        observations: uint8 (N, 4, 84, 84), 0 to 255, one per step.
        first_step: Step of the first one.
    """

    observations: npt.NDArray[np.uint8]
    first_step: int = 0


@dataclass(frozen=True)
class PreferenceGroup:
    """Preference pairs that are drawn from alike.

    Attributes:
        pairs: Indices of games, the better one first.
        share: Of an update's fragment pairs, 0 to 1.
        starts: Where the two fragments of a pair start.
    """

    pairs: tuple[Pair, ...]
    share: float
    starts: FragmentStarts


@dataclass(frozen=True)
class PreferenceDataset:
    """Games and what is known of their order.

    Attributes:
        games: All games; the ranked ones stand where they stand among the run's trajectories.
        tiers: Indices of the ranked games, best tier first.
        perfect: Indices of the perfect games; such a game may be ranked too.
        copies: For each perturbed demonstration, the index of the perfect game it was made from and
            its own.
        recipe: How much each counts.
    """

    games: tuple[Game, ...]
    tiers: tuple[tuple[int, ...], ...]
    recipe: RewardRecipe
    perfect: tuple[int, ...] = ()
    copies: tuple[Pair, ...] = ()

    @property
    def ranked(self) -> tuple[int, ...]:
        """Indices of the ranked games, best first."""
        return tuple(index for tier in self.tiers for index in tier)

    @property
    def pairs(self) -> list[Pair]:
        """The preference pairs of the ranking.

        Raises:
            Invalid: There are fewer than two tiers.
        """
        return preference_pairs(self.tiers)

    @property
    def best(self) -> tuple[int, ...]:
        """Indices of the first tier's games and of the perfect ones that are not ranked."""
        return (*self.tiers[0], *self._unranked_perfect)

    @property
    def _unranked_perfect(self) -> tuple[int, ...]:
        ranked = set(self.ranked)
        return tuple(index for index in self.perfect if index not in ranked)

    def without(self, left_out: Collection[int]) -> PreferenceDataset:
        """Return what is left without some games: no pair, copy or tier has one of them."""
        tiers = (tuple(i for i in tier if i not in left_out) for tier in self.tiers)
        return replace(
            self,
            tiers=tuple(tier for tier in tiers if tier),
            perfect=tuple(index for index in self.perfect if index not in left_out),
            copies=tuple(pair for pair in self.copies if pair[0] not in left_out),
        )

    def groups(self, rng: np.random.Generator) -> list[PreferenceGroup]:
        """Return the pairs of one update: all of the ranking, and of some perfect games.

        Perfect games that are not ranked are better than all but the first tier; whether they are
        better than that nobody has said.
        """
        recipe = self.recipe
        chosen = set(_some(self.perfect, PERFECT_PER_UPDATE, rng))
        unranked = [index for index in self._unranked_perfect if index in chosen]
        perfect = [(i, worse) for i in unranked for tier in self.tiers[1:] for worse in tier]
        copies = [
            pair
            for index in sorted(chosen)
            for pair in _some([p for p in self.copies if p[0] == index], COPIES_PER_PERFECT, rng)
        ]
        perfect_share = recipe.perfect_share if perfect else 0.0
        copies_share = recipe.perturbed_share if copies else 0.0
        own = 1.0 - perfect_share - copies_share
        pairs = tuple(self.pairs)
        wanted = [
            PreferenceGroup(pairs, own * (1.0 - recipe.free_share), FragmentRule.of(recipe).starts),
            PreferenceGroup(pairs, own * recipe.free_share, "any"),
            PreferenceGroup(tuple(perfect), perfect_share, "any"),
            PreferenceGroup(tuple(copies), copies_share, "same"),
        ]
        return [group for group in wanted if group.share > 0.0]


@dataclass(frozen=True)
class PerfectGames:
    """The perfect demonstrations, as a reward model learns from them.

    Attributes:
        trajectories: What an agent would have seen and done in them.
        ranked_as: For each, its index among the ranked games if it is one of them, else None.
        copies: Perturbed demonstrations of them.
    """

    trajectories: Sequence[Trajectory] = ()
    ranked_as: Sequence[int | None] = ()
    copies: Sequence[PerturbedDemonstration] = ()


NO_PERFECT_GAMES = PerfectGames()


def compare(
    trajectories: Sequence[Trajectory],
    tiers: Sequence[Sequence[int]],
    recipe: RewardRecipe,
    perfect: PerfectGames = NO_PERFECT_GAMES,
) -> PreferenceDataset:
    """Put together what a reward model is learned from.

    Args:
        trajectories: The demonstrations.
        tiers: Indices into ``trajectories``, best tier first.
        recipe: How much each kind of pair counts; perfect games that count for nothing are left
            out.
        perfect: The perfect demonstrations and their perturbed demonstrations.
    """
    games = [Game(trajectory.observations) for trajectory in trajectories]
    places = []
    if recipe.perfect_share or recipe.perturbed_share:
        for trajectory, ranked_as in zip(perfect.trajectories, perfect.ranked_as, strict=True):
            if ranked_as is None:
                games.append(Game(trajectory.observations))
            places.append(len(games) - 1 if ranked_as is None else ranked_as)
    copies = []
    if recipe.perturbed_share:
        for copy in perfect.copies:
            copies.append((places[copy.original], len(games)))
            games.append(Game(copy.observations, copy.first_step))
    return PreferenceDataset(
        tuple(games), tuple(tuple(tier) for tier in tiers), recipe, tuple(places), tuple(copies)
    )


def _some(items: Sequence[T], count: int, rng: np.random.Generator) -> list[T]:
    if len(items) <= count:
        return list(items)
    return [items[i] for i in sorted(rng.choice(len(items), count, replace=False).tolist())]
