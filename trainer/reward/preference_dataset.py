"""The dataset of a reward model: trajectories, and which of two is preferred."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
import numpy.typing as npt
from torch import Tensor

from trainer.reward.fragments import preference_pairs
from trainer.reward.model import RewardModel
from trainer.reward.pretraining import read_features
from tril.games.base import Taken
from tril.ranking import Pair
from tril.recipes import RewardRecipe
from tril.recording import Trajectory
from tril.vocabulary.answers import Answer
from tril.vocabulary.facts import Vocabulary

Facts = npt.NDArray[np.float32]


@dataclass(frozen=True)
class ObservedTrajectory:
    """The observations of a trajectory.

    Attributes:
        observations: uint8 (N, 4, 84, 84), 0 to 255, one per step.
        taken: The items taken, in order of time.
        facts: Facts of the game's vocabulary after each step, float32 (T, n_facts);
            None where the reward is not learned from them.
    """

    observations: npt.NDArray[np.uint8]
    taken: tuple[Taken, ...] = ()
    facts: Facts | None = None

    @cached_property
    def features(self) -> Tensor:
        """What a pretrained network reads off the observations, see read_features."""
        return read_features(self.observations)


@dataclass(frozen=True)
class PerfectDemonstrations:
    """The perfect demonstrations, as a reward model learns from them.

    Attributes:
        trajectories: Trajectories of the demonstrations.
        ranked_as: For each, its index among the ranked trajectories; None if it is not ranked.
    """

    trajectories: Sequence[Trajectory] = ()
    ranked_as: Sequence[int | None] = ()


NO_PERFECT_DEMONSTRATIONS = PerfectDemonstrations()


@dataclass(frozen=True)
class GameFacts:
    """What games were like in terms of a vocabulary.

    Attributes:
        words: The vocabulary.
        ranked: Facts of each ranked trajectory, float32 (T, n_facts).
        perfect: Facts of each perfect demonstration.
        varied: Games of varied play, from which a network learns to see the facts, too.
        answers: Answers about statements on the order, the latest last.
    """

    words: Vocabulary
    ranked: Sequence[Facts]
    perfect: Sequence[Facts]
    varied: Sequence[ObservedTrajectory]
    answers: Sequence[Answer] = ()


@dataclass(frozen=True)
class PreferenceDataset:
    """Trajectories and what is known of their order.

    Attributes:
        trajectories: The ranked ones, in the order of the run's, then the others.
        tiers: Indices of the ranked trajectories, best tier first.
        recipe: Recipe of the reward.
        perfect: Indices of the perfect demonstrations, ranked or not.
        vocabulary: The game's, for method "statement".
        varied: Games that nobody ranked, from which facts are learned to be seen.
        answers: Answers about statements on the order, the latest last.
    """

    trajectories: tuple[ObservedTrajectory, ...]
    tiers: tuple[tuple[int, ...], ...]
    recipe: RewardRecipe
    perfect: tuple[int, ...] = ()
    vocabulary: Vocabulary | None = None
    varied: tuple[ObservedTrajectory, ...] = ()
    answers: tuple[Answer, ...] = ()
    _summaries: dict[int, Facts] = field(default_factory=dict, compare=False)

    @classmethod
    def from_demonstrations(
        cls,
        trajectories: Sequence[Trajectory],
        tiers: Sequence[Sequence[int]],
        recipe: RewardRecipe,
        perfect: PerfectDemonstrations = NO_PERFECT_DEMONSTRATIONS,
        facts: GameFacts | None = None,
    ) -> PreferenceDataset:
        """Make the dataset of a ranking and of the perfect demonstrations.

        Args:
            trajectories: The ranked demonstrations.
            tiers: Indices into ``trajectories``, best tier first.
            recipe: Recipe of the reward; method "paper" leaves out perfect demonstrations.
            perfect: The perfect demonstrations.
            facts: Facts of the games, for method "statement".
        """
        of_ranked = facts.ranked if facts else [None] * len(trajectories)
        of_perfect = facts.perfect if facts else [None] * len(perfect.trajectories)
        observed = [_observed(*pair) for pair in zip(trajectories, of_ranked, strict=True)]
        indices = []
        if recipe.method != "paper":
            for trajectory, ranked_as, game_facts in zip(
                perfect.trajectories, perfect.ranked_as, of_perfect, strict=True
            ):
                indices.append(len(observed) if ranked_as is None else ranked_as)
                if ranked_as is None:
                    observed.append(_observed(trajectory, game_facts))
        return cls(
            tuple(observed),
            tuple(tuple(tier) for tier in tiers),
            recipe,
            tuple(indices),
            facts.words if facts else None,
            tuple(facts.varied) if facts else (),
            tuple(facts.answers) if facts else (),
        )

    @property
    def words(self) -> Vocabulary:
        """The game's vocabulary.

        Raises:
            ValueError: The dataset was made without facts.
        """
        if self.vocabulary is None:
            raise ValueError("Expected a dataset with facts of its games.")
        return self.vocabulary

    def summary(self, index: int) -> Facts:
        """Return the facts of a game, float32 (n_facts,)."""
        if index not in self._summaries:
            self._summaries[index] = self.words.summary(self.facts(index))
        return self._summaries[index]

    def facts(self, index: int) -> Facts:
        """Return the facts of a game's steps, float32 (T, n_facts)."""
        facts = self.trajectories[index].facts
        assert facts is not None
        return facts

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
            index: Index of the trajectory.
            last: Number of observations scored, the last ones; None scores all.
        """
        observed = self.trajectories[index]
        scored = slice(None if last is None else -last, None)
        if self.recipe.pretrained:
            return model.score_features(observed.features[scored])
        return model.score(observed.observations[scored])

    def without(self, held_out: Collection[int]) -> PreferenceDataset:
        """Return the dataset without some trajectories."""
        tiers = (tuple(i for i in tier if i not in held_out) for tier in self.tiers)
        return replace(
            self,
            tiers=tuple(tier for tier in tiers if tier),
            perfect=tuple(index for index in self.perfect if index not in held_out),
        )


def _observed(trajectory: Trajectory, facts: Facts | None = None) -> ObservedTrajectory:
    return ObservedTrajectory(trajectory.observations, trajectory.taken, facts)
