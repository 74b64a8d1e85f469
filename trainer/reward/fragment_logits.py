"""The preference logits that one update of a reward network learns from.

The logit of a fragment pair is the better fragment's sum of R minus the worse one's, sums and not
means (Bradley-Terry on returns, as in T-REX, section 4).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cache

import numpy as np
import numpy.typing as npt
import torch
from torch import Tensor

from trainer.nn.devices import device_of, forward_batch
from trainer.nn.screens import channels_last_screens
from trainer.reward.fragments import Fragmenter, Indices
from trainer.reward.model import RewardNetwork
from trainer.reward.preference_dataset import PreferenceDataset

Seed = tuple[int, ...]
"""Seeds all random numbers of one network's training; a stream's number follows it."""

_FRAGMENTS, _PASS = 1, 2


class _Logits:
    """Base of the two kinds of logits.

    Whatever is sampled for an update depends on the seed and the update's number alone, so that an
    interrupted training continues as if it had not been interrupted.

    Args:
        network: The network that is trained.
        dataset: What it is trained on.
        updates: Gradient updates of the training.
        seed: Seeds all random numbers.
    """

    def __init__(self, network: RewardNetwork, dataset: PreferenceDataset, seed: Seed) -> None:
        self.network = network
        self.dataset = dataset
        self.recipe = dataset.recipe
        self._seed = seed
        self._device = device_of(network)

    def prepare(self, on_trajectory: Callable[[], None]) -> None:
        """Compute what all updates share; ``on_trajectory`` is called after each trajectory."""

    def _rng(self, *stream: int) -> np.random.Generator:
        return np.random.default_rng([*self._seed, *stream])


class FragmentLogits(_Logits):
    """Scores every fragment of an update on its own, as T-REX does.

    Fragment pairs are sampled once and gone through in several passes; every
    ``observation_stride``-th observation of a fragment counts.

    Differences from T-REX: fragments are capped at the shorter trajectory of each pair instead of
    the shortest of all, each pass has its own order, and ties form no pair, where T-REX gives them
    a strict label.
    """

    def __init__(
        self, network: RewardNetwork, dataset: PreferenceDataset, updates: int, seed: Seed
    ) -> None:
        super().__init__(network, dataset, seed)
        sizes = [len(one.observations) for one in dataset.trajectories]
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

    def _sample_order(self, number: int) -> npt.NDArray[np.int64]:
        """Return the order of the fragment pairs in a pass."""
        return self._rng(_PASS, number).permutation(len(self._fragments))

    def _observations(self, index: int) -> npt.NDArray[np.uint8]:
        """Return the better fragment, then the worse one, uint8 (2 L, 4, 84, 84)."""
        fragments, parts = self._fragments, []
        for which, starts in (
            (fragments.better, fragments.better_start),
            (fragments.worse, fragments.worse_start),
        ):
            begin = int(starts[index])
            end = begin + int(fragments.length[index])
            trajectory = self.dataset.trajectories[int(which[index])]
            parts.append(trajectory.observations[begin : end : self.recipe.observation_stride])
        return np.concatenate(parts)


class PrefixSumLogits(_Logits):
    """Scores every trajectory once per update, and takes fragments' sums from prefix sums.

    A trajectory is scored at every ``observation_stride``-th step from a random offset.
    Neighbouring observations share three of their four screens, so that the stride loses little
    information and saves most of the time. What the layers of a pretrained network read is computed
    once for all updates, since only its output learns.
    """

    def prepare(self, on_trajectory: Callable[[], None]) -> None:
        """Read the screens of all trajectories if the layers that do so don't learn."""
        if self.recipe.pretrained:
            for trajectory in self.dataset.trajectories:
                _ = trajectory.features
                on_trajectory()

    def __call__(self, update: int) -> Tensor:
        """Return the logits of an update, counted from 0: float32 (pairs_per_update,)."""
        recipe, stride = self.recipe, self.recipe.observation_stride
        rng = self._rng(_FRAGMENTS, update)
        offset = int(rng.integers(stride))
        groups = self.dataset.groups(rng)
        used = sorted({index for group in groups for pair in group.pairs for index in pair})
        taken, begins = zip(*(self._strided(index, offset) for index in used), strict=True)
        sums = self._prefix_sums(taken, begins)
        ends = [begin + len(one) for begin, one in zip(begins, taken, strict=True)]
        row = {index: number for number, index in enumerate(used)}
        counts = _allocate(recipe.pairs_per_update, [group.share for group in groups])
        logits = []
        for group, count in zip(groups, counts, strict=True):
            pairs = [(row[better], row[worse]) for better, worse in group.pairs]
            fragmenter = replace(Fragmenter.of(recipe), starts=group.starts).every(stride)
            drawn = fragmenter.sample(pairs, ends, count, rng, begins)
            better = _returns(sums, drawn.better, drawn.better_start, drawn.length)
            logits.append(better - _returns(sums, drawn.worse, drawn.worse_start, drawn.length))
        return torch.cat(logits)

    def _strided(self, index: int, offset: int) -> tuple[Tensor, int]:
        """Return a trajectory's inputs at steps offset + k * stride, and the first such k."""
        stride, trajectory = self.recipe.observation_stride, self.dataset.trajectories[index]
        first = max(0, -(-(trajectory.first_step - offset) // stride))
        begin = offset + first * stride - trajectory.first_step
        # A trajectory that ends before counts with its last observation.
        begin = min(begin, len(trajectory.observations) - 1)
        if self.recipe.pretrained:
            return trajectory.features[begin::stride], first
        return channels_last_screens(trajectory.observations[begin::stride]), first

    def _prefix_sums(self, taken: tuple[Tensor, ...], begins: Sequence[int]) -> Tensor:
        """Return the sums of R over each trajectory's first k strided steps.

        Returns:
            float32 (trajectories, K + 1), for k from 0 to the largest K.
        """
        parts = torch.split(torch.cat(taken).to(self._device), forward_batch(self._device))
        score = self.network.from_features if self.recipe.pretrained else self.network
        rewards = torch.cat([score(part) for part in parts])
        sizes = [len(one) for one in taken]
        width = max(begin + size for begin, size in zip(begins, sizes, strict=True))
        sums = torch.zeros(len(taken), width + 1, device=self._device)
        for row, part in enumerate(rewards.split_with_sizes(sizes)):
            sums[row, begins[row] + 1 : begins[row] + 1 + len(part)] = part.cumsum(0)
        return sums


def _allocate(count: int, shares: Sequence[float]) -> list[int]:
    """Split a count by shares that add up to 1."""
    edges = np.rint(np.cumsum([0.0, *shares]) * count)
    return [int(part) for part in np.diff(edges)]


def _returns(sums: Tensor, which: Indices, starts: Indices, lengths: Indices) -> Tensor:
    """Return fragments' sums of R from prefix sums, float32 (P,)."""
    rows = torch.from_numpy(which)
    return sums[rows, torch.from_numpy(starts + lengths)] - sums[rows, torch.from_numpy(starts)]
