"""Whether a reward model has understood a ranking (thesis, section 5.1, step 2 of algorithm 1)."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import numpy.typing as npt
import torch

from trainer.nn.devices import CPU
from trainer.progress import Progress, Section
from trainer.reward.fragments import FragmentRule, draw_fragments, fragment_sums, preference_pairs
from trainer.reward.model import RewardModel
from trainer.reward.preference_dataset import (
    NO_PERFECT_GAMES,
    PerfectGames,
    PreferenceDataset,
    compare,
)
from trainer.reward.reward_trainer import RewardTrainer, Seed, calibrate
from tril.ranking import Pair, kendall_tau
from tril.recipes import RewardRecipe
from tril.recording import Trajectory

PASSING_TAU = 0.9
PASSING_HELD_OUT_ACCURACY = 0.9
SNIPPETS_CHECKED = 5_000
SURE = 0.95
"""Share of comparisons that a model which knows the order of two tiers puts right."""
EVIDENCE = 5.0
"""How much likelier guessing has to make what was found, for two tiers to count as not told apart.
"""
_CHECK_STREAM = 1_000_003
"""Keeps the draws of the check apart from those of the training with the same training seed."""


Comparison = tuple[Pair, bool]
"""A preference pair, and whether the model orders it as it was ranked."""


@dataclass(frozen=True)
class ConfusedTiers:
    """Two tiers of which the model puts at least one pair of demonstrations the other way round.

    Attributes:
        better: The tier that was ranked better, counted from 1 for the best.
        worse: The tier that was ranked worse.
        held_out: Whether the order was wrong when one of the two demonstrations was left out of
            the learning; otherwise the predicted returns of the final model contradict it.
        n_right: PreferenceDataset of their demonstrations that were in order.
        n_compared: All comparisons of their demonstrations.
    """

    better: int
    worse: int
    held_out: bool
    n_right: int
    n_compared: int

    @property
    def told_apart(self) -> bool:
        """Whether the comparisons speak for a model that knows the order, some mistakes aside."""
        return are_told_apart(self.n_right, self.n_compared)


def are_told_apart(n_right: int, n_compared: int) -> bool:
    """Tell by how many comparisons were in order whether two tiers are told apart.

    They are not where guessing (half of them in order) explains what was found at least five times
    as well as knowing the order does (95% in order). That is at most 1 of 2, 1 of 3, 4 of 6, 7 of
    10, 15 of 20 and ever closer to 78%: the fewer comparisons, the closer to chance.
    """
    n_wrong = n_compared - n_right
    guessing = n_compared * math.log(0.5)
    knowing = n_right * math.log(SURE) + n_wrong * math.log(1.0 - SURE)
    return guessing - knowing < math.log(EVIDENCE)


@dataclass(frozen=True)
class RankingCheck:
    """How well a reward model agrees with the ranking it was learned from.

    Attributes:
        predicted_returns: Sum of R over the states of each trajectory, by its index; trajectories
            that are not ranked are left out.
        tau: Kendall's tau between the tiers and the predicted returns, -1 to 1.
        pair_accuracy: Share of newly drawn fragment pairs that the model orders as ranked.
        held_out_accuracy: Share of preference pairs ordered as ranked by models that were trained
            without at least one of the two; None where that was not measured.
        confused: The tiers of which some demonstrations are confused, worst first.
        passed: Whether tau and the held-out accuracy are at least 0.9.
    """

    predicted_returns: dict[int, float]
    tau: float
    pair_accuracy: float
    held_out_accuracy: float | None
    confused: tuple[ConfusedTiers, ...]
    passed: bool

    @property
    def not_told_apart(self) -> list[tuple[int, int]]:
        """The pairs of tiers (better, worse) that the model can't tell apart, worst first."""
        found = [(pair.better, pair.worse) for pair in self.confused if not pair.told_apart]
        return list(dict.fromkeys(found))


def check_ranking(
    model: RewardModel,
    trajectories: Sequence[Trajectory],
    tiers: Sequence[Sequence[int]],
    recipe: RewardRecipe,
    training_seed: int,
    progress: Progress,
    checkpoint_folder: Path | None = None,
    perfect: PerfectGames = NO_PERFECT_GAMES,
    device: torch.device = CPU,
) -> RankingCheck:
    """Check a reward model against the ranking it was learned from.

    Args:
        model: What train_reward_model returned.
        trajectories: The demonstrations.
        tiers: Indices into ``trajectories``, best tier first.
        recipe: How the model was learned; ``folds`` and ``fold_updates`` say how the accuracy on
            demonstrations left out is measured.
        training_seed: Feeds the draws of fragments and the folds' models.
        progress: Told of the folds' updates and, as ``held_out_accuracy``, of each fold's result.
        checkpoint_folder: As of train_reward_model.
        perfect: As of train_reward_model.
        device: Where the folds' models are learned.

    Raises:
        RunCancelled: Raised by ``progress``.
    """
    rng = np.random.default_rng([training_seed, _CHECK_STREAM])
    pairs = preference_pairs(tiers)
    scores = {i: model.score(trajectories[i].observations) for tier in tiers for i in tier}
    returns = {i: float(values[1:].sum(dtype=np.float64)) for i, values in scores.items()}
    tau = kendall_tau(tiers, returns)
    seed = (training_seed, _CHECK_STREAM)
    comparisons = compare(trajectories, tiers, recipe, perfect)
    left_out = _cross_validate(comparisons, seed, progress, checkpoint_folder, device)
    held_out = float(np.mean([right for _, right in left_out])) if left_out else None
    tier_of = {i: number for number, tier in enumerate(tiers, 1) for i in tier}
    by_return = [(pair, returns[pair[0]] > returns[pair[1]]) for pair in pairs]
    confused = _confused(tier_of, by_return, left_out)
    return RankingCheck(
        predicted_returns=returns,
        tau=tau,
        pair_accuracy=_fragment_accuracy(scores, pairs, recipe, rng),
        held_out_accuracy=held_out,
        confused=confused,
        passed=tau >= PASSING_TAU and (held_out is None or held_out >= PASSING_HELD_OUT_ACCURACY),
    )


def _fragment_accuracy(
    scores: dict[int, npt.NDArray[np.float32]],
    pairs: Sequence[Pair],
    recipe: RewardRecipe,
    rng: np.random.Generator,
) -> float:
    """Return the share of newly drawn fragment pairs whose sums of R are ordered as ranked."""
    sizes = [len(scores[i]) if i in scores else 1 for i in range(max(scores) + 1)]
    drawn = draw_fragments(pairs, sizes, FragmentRule.of(recipe), SNIPPETS_CHECKED, rng)
    sums = np.empty((2, len(drawn)))
    for side, (which, starts) in enumerate(
        [(drawn.better, drawn.better_start), (drawn.worse, drawn.worse_start)]
    ):
        for index in np.unique(which).tolist():
            of = which == index
            sums[side, of] = fragment_sums(scores[index], starts[of], drawn.length[of])
    return float(np.mean(sums[0] > sums[1]))


def _cross_validate(
    comparisons: PreferenceDataset,
    seed: Seed,
    progress: Progress,
    checkpoint_folder: Path | None,
    device: torch.device,
) -> list[Comparison]:
    """Train without some demonstrations and order them; return which pairs were in order.

    A pair counts in each fold that leaves at least one of its two demonstrations out. Games are
    compared over as many steps as the shorter one has, as fragments are.
    """
    recipe, ranked = comparisons.recipe, comparisons.ranked
    n_folds = min(recipe.folds, len(ranked))
    if n_folds < 2:
        return []
    comparisons = replace(comparisons, recipe=recipe.of_a_fold)
    # Spread over the ranks, so that each fold leaves out good and bad ones.
    fold_of = {i: place % n_folds for place, i in enumerate(ranked)}
    compared: list[Comparison] = []
    for fold in range(n_folds):
        kept = comparisons.without({i for i in ranked if fold_of[i] == fold})
        if len(kept.tiers) < 2:
            continue
        job = RewardTrainer(
            kept,
            recipe.fold_updates,
            (*seed, fold),
            checkpoint_folder and checkpoint_folder / f"fold-{fold}.safetensors",
            device,
        )
        first, total = fold * recipe.fold_updates, n_folds * recipe.fold_updates
        section = Section(progress, first, total)
        network = job.train(_WithoutValues(section))
        model = calibrate([network], kept, standardise=False)
        scores = {i: model.score(comparisons.games[i].observations) for i in ranked}
        pairs = [p for p in comparisons.pairs if fold in (fold_of[p[0]], fold_of[p[1]])]
        found = [(p, _in_order(scores[p[0]], scores[p[1]])) for p in pairs]
        compared += found
        accuracy = float(np.mean([right for _, right in found]))
        section.advance(recipe.fold_updates, recipe.fold_updates, {"held_out_accuracy": accuracy})
    return compared


def _in_order(better: npt.NDArray[np.float32], worse: npt.NDArray[np.float32]) -> bool:
    length = min(len(better), len(worse))
    return bool(better[:length].sum(dtype=np.float64) > worse[:length].sum(dtype=np.float64))


def _confused(
    tier_of: dict[int, int], by_return: Sequence[Comparison], held_out: Sequence[Comparison]
) -> tuple[ConfusedTiers, ...]:
    by_tiers: dict[tuple[int, int, bool], list[bool]] = defaultdict(list)
    for compared, left_out in ((by_return, False), (held_out, True)):
        for (better, worse), right in compared:
            by_tiers[tier_of[better], tier_of[worse], left_out].append(right)
    found = [
        ConfusedTiers(*tiers, n_right=sum(right), n_compared=len(right))
        for tiers, right in by_tiers.items()
        if not all(right)
    ]
    # The final model's own contradictions first, then those that are furthest apart.
    return tuple(sorted(found, key=lambda c: (c.held_out, c.better - c.worse, c.better)))


class _WithoutValues:
    """Passes progress on without the curves, which belong to the final model's training."""

    def __init__(self, progress: Progress) -> None:
        self._progress = progress

    def advance(self, done: int, total: int, values: object = None) -> None:
        self._progress.advance(done, total)
