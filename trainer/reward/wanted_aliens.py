"""Inferring which aliens are wanted, and a reward network that says so.

A pretrained network's R is linear in which aliens are left and in how far rows have been swept. Its
weights are made of the labels' posterior means, see tril.analysis.wanted_aliens, so that R is their
sum over what has been hit. Which aliens a demonstration hits is known from its replay; what R makes
of a game is read off its screens alone.
"""

from __future__ import annotations

import numpy as np
import torch

from trainer.progress import Progress
from trainer.reward.fragment_logits import Seed
from trainer.reward.model import RewardNetwork
from trainer.reward.preference_dataset import ObservedTrajectory, PreferenceDataset
from trainer.reward.pretraining import pretrained_network
from tril.analysis.wanted_aliens import (
    BURN_IN,
    LABELS,
    N_ALIENS,
    Array,
    Hits,
    Posterior,
    best_games,
    learned_order,
    log_prior,
    pair_weights,
)
from tril.games.space_invaders.memory import COLUMNS, FRAMES_PER_STEP, ROWS

_TINY = 1e-3

_STREAM = 0
"""Number of the random stream."""


class WantedAliensTrainer:
    """Infers which aliens are wanted, and makes a reward network of it.

    Args:
        dataset: Dataset to infer from.
        passes: Passes of Gibbs sampling over all columns (Geman and Geman 1984).
        seed: Seeds all random numbers.
    """

    def __init__(self, dataset: PreferenceDataset, passes: int, seed: Seed) -> None:
        self._dataset = dataset
        self._passes = passes
        self._rng = np.random.default_rng([*seed, _STREAM])

    def train(self, progress: Progress) -> RewardNetwork:
        """Return the network; ``progress`` counts passes."""
        dataset = self._dataset
        best = best_games(dataset.tiers, dataset.perfect)
        hits = {
            index: _hits_of(dataset.trajectories[index])
            for index in dict.fromkeys((*dataset.ranked, *best))
        }
        hits_of_best = [hits[index] for index in best]
        order = learned_order(hits_of_best)
        pairs = dataset.pairs
        weights = pair_weights(pairs, dataset.tiers)
        posterior = Posterior(hits, pairs, weights, log_prior(hits_of_best), order)
        labels = self._sample(posterior, progress)
        network = pretrained_network(self._rng)
        set_labels(network, labels, order)
        return network

    def _sample(self, posterior: Posterior, progress: Progress) -> Array:
        """Return the labels' posterior means, float64 (36,), -1 to 1."""
        first = int(BURN_IN * self._passes)
        probabilities = np.zeros((COLUMNS, ROWS + 1))
        for number in range(1, self._passes + 1):
            drawn = posterior.sample(self._rng)
            if number > first:
                probabilities += drawn / (self._passes - first)
            progress.advance(number, self._passes)
        labels: Array = (probabilities @ LABELS).T.ravel()
        return labels


def _hits_of(observed: ObservedTrajectory) -> Hits:
    hits = ((hit.row, hit.column, hit.frame) for hit in observed.taken)
    return Hits.of(hits, (len(observed.observations) - 1) * FRAMES_PER_STEP)


def labels_of(network: RewardNetwork) -> tuple[Array, Array]:
    """Return the labels and the order that ``set_labels`` was given, float64 (36,) each.

    The order of an alien that is hardly wanted is 0.
    """
    weights = network.output.weight[0].detach().cpu().double().numpy()
    swept = np.zeros((ROWS, COLUMNS))
    swept[:, 1:] = weights[N_ALIENS:].reshape(ROWS, COLUMNS - 1)
    labels = swept.ravel() - weights[:N_ALIENS]
    probabilities = (labels + 1.0) / 2.0
    order = np.divide(
        swept.ravel(), probabilities, out=np.zeros(N_ALIENS), where=probabilities > _TINY
    )
    return labels, order


def set_labels(network: RewardNetwork, labels: Array, order: Array) -> None:
    """Make a pretrained network's R the sum of the labels of what has been hit, but for a constant.

    Args:
        network: Network to change: its output is replaced.
        labels: Mean label of each alien, float64 (36,), -1 to 1.
        order: See learned_order.
    """
    swept = (labels + 1.0) / 2.0 * order
    weights = np.concatenate([swept - labels, swept.reshape(ROWS, COLUMNS)[:, 1:].ravel()])
    with torch.no_grad():
        network.output.weight.copy_(torch.from_numpy(weights)[None])
        network.output.bias.zero_()
