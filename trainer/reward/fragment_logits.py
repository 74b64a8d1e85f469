"""The preference logits that one update of a reward network learns from.

The logit of a fragment pair is the better fragment's sum of R minus the worse one's, sums and not
means (Bradley-Terry on returns, as in T-REX, section 4).
"""

from __future__ import annotations

from functools import cache

import numpy as np
import numpy.typing as npt
import torch
from torch import Tensor

from trainer.nn.devices import device_of
from trainer.nn.screens import channels_last_screens
from trainer.reward.fragments import Fragmenter
from trainer.reward.model import RewardNetwork
from trainer.reward.preference_dataset import PreferenceDataset

Seed = tuple[int, ...]
"""Seeds all random numbers of one network's training; a stream's number follows it."""

_FRAGMENTS, _PASS = 1, 2


class FragmentLogits:
    """Scores every fragment of an update on its own, as T-REX does.

    Fragment pairs are sampled once and gone through in several passes; every
    ``observation_stride``-th observation of a fragment counts.

    Differences from T-REX: fragments are capped at the shorter trajectory of each pair instead of
    the shortest of all, each pass has its own order, and ties form no pair, where T-REX gives them
    a strict label.

    Whatever is sampled for an update depends on the seed and the update's number alone, so that an
    interrupted training continues as if it had not been interrupted.

    Args:
        network: The network that is trained.
        dataset: Dataset to train on.
        updates: Gradient updates of the training.
        seed: Seeds all random numbers.
    """

    def __init__(
        self, network: RewardNetwork, dataset: PreferenceDataset, updates: int, seed: Seed
    ) -> None:
        self.network = network
        self.dataset = dataset
        self.recipe = dataset.recipe
        self._seed = seed
        self._device = device_of(network)
        sizes = [len(trajectory.observations) for trajectory in dataset.trajectories]
        n_pairs = self.recipe.fragment_pairs or updates * self.recipe.pairs_per_update
        self._fragments = Fragmenter.of(self.recipe).sample(
            dataset.pairs, sizes, n_pairs, self._rng(_FRAGMENTS)
        )
        self._order = cache(self._sample_order)

    def __call__(self, update: int) -> Tensor:
        """Return the logits of an update, counted from 0: float32 (pairs_per_update,)."""
        first = update * self.recipe.pairs_per_update
        n_pairs = len(self._fragments)
        pairs = [
            self._observations(int(self._order(place // n_pairs)[place % n_pairs]))
            for place in range(first, first + self.recipe.pairs_per_update)
        ]
        screens = channels_last_screens(np.concatenate(pairs))
        rewards = self.network(screens.to(self._device))
        lengths = [half for pair in pairs for half in [len(pair) // 2] * 2]
        returns = torch.stack([part.sum() for part in rewards.split_with_sizes(lengths)])
        return returns[0::2] - returns[1::2]

    def _rng(self, *stream: int) -> np.random.Generator:
        return np.random.default_rng([*self._seed, *stream])

    def _sample_order(self, number: int) -> npt.NDArray[np.int64]:
        """Return the order of the fragment pairs in a pass."""
        return self._rng(_PASS, number).permutation(len(self._fragments))

    def _observations(self, index: int) -> npt.NDArray[np.uint8]:
        """Return the better fragment, then the worse one, uint8 (2 L, 4, 84, 84)."""
        fragments, parts = self._fragments, []
        for indices, starts in (
            (fragments.better, fragments.better_start),
            (fragments.worse, fragments.worse_start),
        ):
            begin = int(starts[index])
            end = begin + int(fragments.length[index])
            trajectory = self.dataset.trajectories[int(indices[index])]
            parts.append(trajectory.observations[begin : end : self.recipe.observation_stride])
        return np.concatenate(parts)
