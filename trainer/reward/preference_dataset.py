"""The dataset of a reward model: trajectories, and which of two is preferred."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TypeVar

import numpy as np
import numpy.typing as npt
from torch import Tensor

from trainer.reward.fragments import Fragmenter, FragmentStarts, preference_pairs
from trainer.reward.model import RewardModel
from trainer.reward.perturbation import PerturbedDemonstration
from trainer.reward.pretraining import read_features
from tril.game.episode import Hit
from tril.ranking import Pair
from tril.recipes import RewardRecipe
from tril.recording import Trajectory

T = TypeVar("T")

PERFECT_PER_UPDATE = 6
"""Perfect demonstrations that one update scores; all of them would make it twice as slow."""

PERTURBED_PER_PERFECT = 2
"""Perturbed copies of each of these that one update scores."""


@dataclass(frozen=True)
class ObservedTrajectory:
    """The observations of a trajectory, from its start or from a later step on.

    Attributes:
        observations: uint8 (N, 4, 84, 84), 0 to 255, one per step.
        first_step: Step of the first observation.
        hits: The aliens shot in a whole trajectory, in order of time.
    """

    observations: npt.NDArray[np.uint8]
    first_step: int = 0
    hits: tuple[Hit, ...] = ()

    @cached_property
    def features(self) -> Tensor:
        """What a pretrained network reads off the observations, see read_features."""
        return read_features(self.observations)


@dataclass(frozen=True)
class PerfectDemonstrations:
    """The perfect demonstrations, as a reward model learns from them.

    Attributes:
        trajectories: Their trajectories.
        ranked_as: For each, its index among the ranked trajectories; None if it is not ranked.
        perturbed: Perturbed copies of them.
    """

    trajectories: Sequence[Trajectory] = ()
    ranked_as: Sequence[int | None] = ()
    perturbed: Sequence[PerturbedDemonstration] = ()


NO_PERFECT_DEMONSTRATIONS = PerfectDemonstrations()


@dataclass(frozen=True)
class PreferenceGroup:
    """Preference pairs that fragments are sampled from in the same way.

    Attributes:
        pairs: Indices of trajectories, the better one first.
        share: Of an update's fragment pairs, 0 to 1.
        starts: Where the two fragments of a pair start.
    """

    pairs: tuple[Pair, ...]
    share: float
    starts: FragmentStarts


@dataclass(frozen=True)
class PreferenceDataset:
    """Trajectories and what is known of their order.

    Attributes:
        trajectories: The ranked ones, in the order of the run's, then the others.
        tiers: Indices of the ranked trajectories, best tier first.
        recipe: How much each kind of pair counts.
        perfect: Indices of the perfect demonstrations, ranked or not.
        perturbed: For each perturbed copy, the index of its original and its own.
    """

    trajectories: tuple[ObservedTrajectory, ...]
    tiers: tuple[tuple[int, ...], ...]
    recipe: RewardRecipe
    perfect: tuple[int, ...] = ()
    perturbed: tuple[Pair, ...] = ()

    @classmethod
    def from_demonstrations(
        cls,
        trajectories: Sequence[Trajectory],
        tiers: Sequence[Sequence[int]],
        recipe: RewardRecipe,
        perfect: PerfectDemonstrations = NO_PERFECT_DEMONSTRATIONS,
    ) -> PreferenceDataset:
        """Make the dataset of a ranking and of the perfect demonstrations.

        Args:
            trajectories: The ranked demonstrations.
            tiers: Indices into ``trajectories``, best tier first.
            recipe: How much each kind of pair counts; kinds that count nothing are left out.
            perfect: The perfect demonstrations and their perturbed copies.
        """
        observed = [_observed(trajectory) for trajectory in trajectories]
        indices = []
        if recipe.uses_perfect:
            for trajectory, ranked_as in zip(perfect.trajectories, perfect.ranked_as, strict=True):
                indices.append(len(observed) if ranked_as is None else ranked_as)
                if ranked_as is None:
                    observed.append(_observed(trajectory))
        perturbed = []
        if recipe.perturbed_share:
            for copy in perfect.perturbed:
                perturbed.append((indices[copy.original], len(observed)))
                observed.append(ObservedTrajectory(copy.observations, copy.first_step))
        tier_indices = tuple(tuple(tier) for tier in tiers)
        return cls(tuple(observed), tier_indices, recipe, tuple(indices), tuple(perturbed))

    @property
    def ranked(self) -> tuple[int, ...]:
        """Indices of the ranked trajectories, best first."""
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
        """Indices of the first tier and of the perfect demonstrations that are not ranked."""
        return (*self.tiers[0], *self._unranked_perfect)

    @property
    def _unranked_perfect(self) -> tuple[int, ...]:
        ranked = set(self.ranked)
        return tuple(index for index in self.perfect if index not in ranked)

    def score(
        self, model: RewardModel, index: int, last: int | None = None
    ) -> npt.NDArray[np.float32]:
        """Return R of a trajectory's observations, float32 (N,), by a model of this recipe.

        Args:
            model: The model.
            index: Of the trajectory.
            last: How many observations are scored, the last ones; None scores all.
        """
        observed = self.trajectories[index]
        scored = slice(None if last is None else -last, None)
        if self.recipe.pretrained:
            return model.score_features(observed.features[scored])
        return model.score(observed.observations[scored])

    def without(self, held_out: Collection[int]) -> PreferenceDataset:
        """Return the dataset without some trajectories and without their perturbed copies."""
        tiers = (tuple(i for i in tier if i not in held_out) for tier in self.tiers)
        return replace(
            self,
            tiers=tuple(tier for tier in tiers if tier),
            perfect=tuple(index for index in self.perfect if index not in held_out),
            perturbed=tuple(pair for pair in self.perturbed if pair[0] not in held_out),
        )

    def groups(self, rng: np.random.Generator) -> list[PreferenceGroup]:
        """Return the preference pairs of one update: the ranking's, and some perfect ones'.

        Unranked perfect demonstrations are preferred to all tiers but the first; how they compare
        with that one is unknown.
        """
        recipe = self.recipe
        chosen = set(_sample_at_most(PERFECT_PER_UPDATE, self.perfect, rng))
        unranked = [index for index in self._unranked_perfect if index in chosen]
        perfect = [(i, worse) for i in unranked for tier in self.tiers[1:] for worse in tier]
        perturbed = [
            pair
            for index in sorted(chosen)
            for pair in _sample_at_most(
                PERTURBED_PER_PERFECT, [p for p in self.perturbed if p[0] == index], rng
            )
        ]
        perfect_share = recipe.perfect_share if perfect else 0.0
        perturbed_share = recipe.perturbed_share if perturbed else 0.0
        own = 1.0 - perfect_share - perturbed_share
        pairs, starts = tuple(self.pairs), Fragmenter.of(recipe).starts
        groups = [
            PreferenceGroup(pairs, own * (1.0 - recipe.free_share - recipe.end_share), starts),
            PreferenceGroup(pairs, own * recipe.end_share, "end"),
            PreferenceGroup(pairs, own * recipe.free_share, "any"),
            PreferenceGroup(tuple(perfect), perfect_share, "any"),
            PreferenceGroup(tuple(perturbed), perturbed_share, "same"),
        ]
        return [group for group in groups if group.share > 0.0]


def _observed(trajectory: Trajectory) -> ObservedTrajectory:
    return ObservedTrajectory(trajectory.observations, hits=trajectory.hits)


def _sample_at_most(count: int, items: Sequence[T], rng: np.random.Generator) -> list[T]:
    """Return items drawn without replacement, in their order; all if they are no more."""
    if len(items) <= count:
        return list(items)
    return [items[i] for i in sorted(rng.choice(len(items), count, replace=False).tolist())]
