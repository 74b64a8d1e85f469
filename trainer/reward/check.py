"""Check of a reward model against its ranking (thesis, section 5.1, step 2 of algorithm 1)."""

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
from trainer.progress import OffsetProgress, Progress
from trainer.reward.fragment_logits import Seed
from trainer.reward.fragments import Fragmenter, fragment_returns
from trainer.reward.model import RewardModel, RewardNetwork, Spread
from trainer.reward.preference_dataset import PreferenceDataset
from trainer.reward.reward_trainer import network_trainer, standardisation
from trainer.reward.statements import shuffled_orders_as_good, understanding_of
from tril.ranking import Pair, kendall_tau
from tril.recipes import RewardRecipe
from tril.recording import LEVEL_STEPS
from tril.vocabulary.understanding import MOST_AS_GOOD

CONFIDENT_TAU = 0.75
"""Rankings of columns with three swapped neighbours reach 0.81 to 0.91.

See docs/decisions/08-ranking-check.md.
"""
CONFIDENT_ACCURACY = 0.9
"""Held-out accuracy from which on, with CONFIDENT_TAU, nothing needs to be said."""
PASSING_TAU = 0.5
PASSING_ACCURACY = 0.6
"""Of 200 rankings in a random order 17 pass (docs/decisions/08-ranking-check.md)."""
N_FRAGMENT_PAIRS = 5_000
SURE = 0.95
"""Accuracy of a model that knows the order of two tiers."""
EVIDENCE = 5.0
"""Likelihood ratio of guessing to knowing from which on two tiers count as not told apart."""
_CHECK_STREAM = 1_000_003
"""Separates the check's random numbers from those of the training with the same training seed."""

PairOutcome = tuple[Pair, bool]
"""A preference pair, and whether the model orders it as ranked."""


@dataclass(frozen=True)
class ConfusedTiers:
    """Two tiers of which the model orders at least one pair of demonstrations wrongly.

    Attributes:
        better: The tier that was ranked better, counted from 1 for the best.
        worse: The tier that was ranked worse.
        held_out: Whether the order was wrong when one of the two demonstrations was held out;
            otherwise the final levels of the final model contradict it.
        n_right: Comparisons of their demonstrations that the model orders as ranked.
        n_compared: All comparisons of their demonstrations.
    """

    better: int
    worse: int
    held_out: bool
    n_right: int
    n_compared: int

    @property
    def told_apart(self) -> bool:
        """Whether the comparisons suggest that the model knows the order, some errors aside."""
        return are_distinguished(self.n_right, self.n_compared)


def are_distinguished(n_right: int, n_compared: int) -> bool:
    """Return whether a model distinguishes two tiers, given its comparisons of demonstrations.

    It does not where guessing (50% right) explains the outcome at least five times as well as
    knowing the order (95% right). That is at most 1 right of 2, 1 of 3, 4 of 6, 7 of 10, 15 of 20
    and ever closer to 78%: the fewer comparisons, the closer to chance.
    """
    n_wrong = n_compared - n_right
    guessing = n_compared * math.log(0.5)
    knowing = n_right * math.log(SURE) + n_wrong * math.log(1.0 - SURE)
    return guessing - knowing < math.log(EVIDENCE)


@dataclass(frozen=True)
class RankingCheck:
    """How well a reward model agrees with the ranking it was learned from.

    Attributes:
        predicted_returns: Sum of R over the states of each ranked trajectory, by its index.
        final_levels: Mean level of its last 25 observations, by its index. A return grows with the
            length of a game, which says nothing of what was achieved.
        tau: Kendall's tau between the tiers and the final levels, -1 to 1.
        pair_accuracy: Share of newly sampled fragment pairs that the model orders as ranked.
        held_out_accuracy: Share of preference pairs that are ordered as ranked by models which
            were trained without at least one of the two; None where it was not measured.
        confused: The tiers with confused demonstrations, worst first.
        passed: Whether there is something to learn: tau is at least 0.5 and the held-out accuracy
            at least 0.6; of a statement, whether few shuffled orders are explained as well.
        n_as_good: Shuffled orders that statements explain as well; None of rewards that are
            learned otherwise.
    """

    predicted_returns: dict[int, float]
    final_levels: dict[int, float]
    tau: float
    pair_accuracy: float
    held_out_accuracy: float | None
    confused: tuple[ConfusedTiers, ...]
    passed: bool
    n_as_good: int | None = None

    @property
    def is_confident(self) -> bool:
        """Whether the model orders the demonstrations as ranked, single errors aside."""
        accuracy = self.held_out_accuracy
        return self.tau >= CONFIDENT_TAU and (accuracy is None or accuracy >= CONFIDENT_ACCURACY)

    @property
    def not_told_apart(self) -> list[tuple[int, int]]:
        """The pairs of tiers (better, worse) that the model can't tell apart, worst first."""
        pairs = [(pair.better, pair.worse) for pair in self.confused if not pair.told_apart]
        return list(dict.fromkeys(pairs))


def check_ranking(
    model: RewardModel,
    dataset: PreferenceDataset,
    training_seed: int,
    progress: Progress,
    checkpoint_folder: Path | None = None,
    device: torch.device = CPU,
) -> tuple[RankingCheck, RewardModel]:
    """Check a reward model against the ranking it was learned from.

    Returns:
        The check, and the model; of a pretrained network it then knows how sure it is, see
        ``jackknife``.

    Args:
        model: Model that train_reward_model returned for the dataset.
        dataset: What it was learned from; ``folds`` and ``fold_updates`` of its recipe say how the
            held-out accuracy is measured.
        training_seed: Seeds the sampled fragments and the folds' networks.
        progress: Counts the folds' updates; receives each fold's ``held_out_accuracy``.
        checkpoint_folder: See train_reward_model.
        device: Device that the folds' networks learn on.

    Raises:
        RunCancelled: Raised by ``progress``.
    """
    seed = (training_seed, _CHECK_STREAM)
    tiers, pairs = dataset.tiers, dataset.pairs
    rewards = {i: dataset.score(model, i) for i in dataset.ranked}
    returns = {i: float(values[1:].sum(dtype=np.float64)) for i, values in rewards.items()}
    folds: list[RewardNetwork] = []
    n_as_good = None
    if dataset.recipe.method == "statement":
        # A statement is about all of a game; what it lacks to a whole one is forfeited.
        horizon = dataset.words.horizon
        levels = {
            i: float(model.level(values[1:]).sum(dtype=np.float64)) / horizon
            for i, values in rewards.items()
        }
        n_as_good = shuffled_orders_as_good(dataset)
        held_out = _cross_validate_statement(dataset, progress)
    else:
        levels = {i: final_level(model.level(values)) for i, values in rewards.items()}
        held_out = _cross_validate(dataset, seed, progress, folds, checkpoint_folder, device)
    tau = kendall_tau(tiers, levels)
    accuracy = _accuracy(held_out) if held_out else None
    tier_of = {i: number for number, tier in enumerate(tiers, 1) for i in tier}
    by_level = [(pair, levels[pair[0]] > levels[pair[1]]) for pair in pairs]
    check = RankingCheck(
        predicted_returns=returns,
        final_levels=levels,
        tau=tau,
        pair_accuracy=_fragment_accuracy(
            rewards, pairs, dataset.recipe, np.random.default_rng(seed)
        ),
        held_out_accuracy=accuracy,
        confused=_confused(tier_of, by_level, held_out),
        passed=(
            tau >= PASSING_TAU and (accuracy is None or accuracy >= PASSING_ACCURACY)
            if n_as_good is None
            else n_as_good <= MOST_AS_GOOD
        ),
        n_as_good=n_as_good,
    )
    if dataset.recipe.pretrained:
        model = replace(model, spread=jackknife(folds, dataset))
    return check, model


def jackknife(folds: Sequence[RewardNetwork], dataset: PreferenceDataset) -> Spread | None:
    """Return the spread of R over networks that were each trained without a group of the games.

    The variance of an estimate is (K - 1) / K times the sum of the squared deviations of its K
    values without one group each (the delete-a-group jackknife, Kott 2001). The networks' outputs
    are standardised as the final one's, see trainer.reward.reward_trainer.calibrate.

    Args:
        folds: Pretrained networks, which differ in their outputs alone.
        dataset: All games.

    Returns:
        None if there are fewer than two networks, or one that gives all states the same value.
    """
    outputs = []
    for network in folds:
        offset, scale = standardisation(network, dataset)
        if scale < 1e-6:
            return None
        outputs.append(((network.output.weight[0]) / scale, (network.output.bias - offset) / scale))
    if len(outputs) < 2:
        return None
    factor = math.sqrt(1.0 - 1.0 / len(outputs))
    weights = torch.stack([weight.detach().cpu() for weight, _ in outputs])
    biases = torch.cat([bias.detach().cpu() for _, bias in outputs])
    return Spread(factor * (weights - weights.mean(0)), factor * (biases - biases.mean()))


def final_level(levels: npt.NDArray[np.float32]) -> float:
    """Return the mean of a trajectory's last 25 levels, float32 (N,), or of all if fewer."""
    return float(levels[-LEVEL_STEPS:].mean(dtype=np.float64))


def _fragment_accuracy(
    rewards: dict[int, npt.NDArray[np.float32]],
    pairs: Sequence[Pair],
    recipe: RewardRecipe,
    rng: np.random.Generator,
) -> float:
    """Return the share of newly sampled fragment pairs whose sums of R are ordered as ranked."""
    sizes = [len(rewards[i]) if i in rewards else 1 for i in range(max(rewards) + 1)]
    drawn = Fragmenter.of(recipe).sample(pairs, sizes, N_FRAGMENT_PAIRS, rng)
    returns = np.empty((2, len(drawn)))
    for side, (indices, starts) in enumerate(
        [(drawn.better, drawn.better_start), (drawn.worse, drawn.worse_start)]
    ):
        for index in np.unique(indices).tolist():
            of = indices == index
            returns[side, of] = fragment_returns(rewards[index], starts[of], drawn.length[of])
    return float(np.mean(returns[0] > returns[1]))


def _cross_validate(
    dataset: PreferenceDataset,
    seed: Seed,
    progress: Progress,
    networks: list[RewardNetwork],
    checkpoint_folder: Path | None,
    device: torch.device,
) -> list[PairOutcome]:
    """Train networks with some demonstrations held out, and return how they order pairs with these.

    The networks are appended to ``networks``. A pair counts in each fold that holds out at least
    one of its two demonstrations. They are compared by their final levels.
    """
    recipe, ranked = dataset.recipe, dataset.ranked
    n_folds = min(recipe.folds, len(ranked))
    if n_folds < 2:
        return []
    dataset = replace(dataset, recipe=recipe.of_fold)
    # Spread over the ranks, so that each fold holds out good and bad ones.
    fold_of = {i: place % n_folds for place, i in enumerate(ranked)}
    updates = recipe.fold_updates
    outcomes: list[PairOutcome] = []
    for fold in range(n_folds):
        training_games = dataset.without({i for i in ranked if fold_of[i] == fold})
        if len(training_games.tiers) < 2:
            continue
        checkpoint = checkpoint_folder and checkpoint_folder / f"fold-{fold}.safetensors"
        trainer = network_trainer(training_games, updates, (*seed, fold), checkpoint, device)
        first, total = fold * updates, n_folds * updates
        # Loss and accuracy are curves of the final model's training.
        network = trainer.train(OffsetProgress(progress, first, total, with_values=False))
        networks.append(network)
        model = RewardModel(network)
        levels = {i: final_level(dataset.score(model, i, LEVEL_STEPS)) for i in ranked}
        pairs = [p for p in dataset.pairs if fold in (fold_of[p[0]], fold_of[p[1]])]
        fold_outcomes = [(p, levels[p[0]] > levels[p[1]]) for p in pairs]
        outcomes += fold_outcomes
        progress.advance(first + updates, total, {"held_out_accuracy": _accuracy(fold_outcomes)})
    return outcomes


def _cross_validate_statement(dataset: PreferenceDataset, progress: Progress) -> list[PairOutcome]:
    """Order pairs by statements inferred without at least one of their two games."""
    ranked = dataset.ranked
    n_folds = min(dataset.recipe.folds, len(ranked))
    outcomes: list[PairOutcome] = []
    if n_folds < 2:
        return outcomes
    fold_of = {i: place % n_folds for place, i in enumerate(ranked)}
    summaries = np.stack([dataset.summary(i) for i in ranked])
    for fold in range(n_folds):
        held_out = {i for i in ranked if fold_of[i] == fold}
        if len(dataset.without(held_out).tiers) < 2:
            continue
        values = understanding_of(dataset, held_out).value(summaries)
        value_of = dict(zip(ranked, values.tolist(), strict=True))
        pairs = [p for p in dataset.pairs if fold in (fold_of[p[0]], fold_of[p[1]])]
        fold_outcomes = [(p, value_of[p[0]] > value_of[p[1]]) for p in pairs]
        outcomes += fold_outcomes
        progress.advance(fold + 1, n_folds, {"held_out_accuracy": _accuracy(fold_outcomes)})
    return outcomes


def _accuracy(outcomes: Sequence[PairOutcome]) -> float:
    return float(np.mean([right for _, right in outcomes]))


def _confused(
    tier_of: dict[int, int], by_level: Sequence[PairOutcome], held_out: Sequence[PairOutcome]
) -> tuple[ConfusedTiers, ...]:
    by_tiers: dict[tuple[int, int, bool], list[bool]] = defaultdict(list)
    for outcomes, is_held_out in ((by_level, False), (held_out, True)):
        for (better, worse), right in outcomes:
            by_tiers[tier_of[better], tier_of[worse], is_held_out].append(right)
    confused = [
        ConfusedTiers(*tiers, n_right=sum(right), n_compared=len(right))
        for tiers, right in by_tiers.items()
        if not all(right)
    ]
    # The final model's own contradictions first, then those that are furthest apart.
    return tuple(sorted(confused, key=lambda c: (c.held_out, c.better - c.worse, c.better)))
