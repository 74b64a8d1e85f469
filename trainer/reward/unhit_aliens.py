"""What no perfect demonstration does: hitting aliens that all of them leave standing.

A dozen games of a behaviour show few of the thirty aliens that it does not ask for being hit. How
the others count would be left to chance: R of an alien that nobody hits can be of either sign, and
an imitator finds those that pay. So states of perfect demonstrations are preferred to the same
states with one more of these aliens gone. Nobody plays such games; a pretrained network's R is
linear in which aliens are left, so that what it would read off their screens is known.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import torch
from torch import Tensor

from trainer.reward.model import RewardNetwork
from tril.game.space_invaders import COLUMNS, ROWS

N_ALIENS = ROWS * COLUMNS

_STANDING = 0.5
"""Probability from which an alien counts as left."""


class UnhitAliens:
    """States of perfect demonstrations, and the same without an alien that none of these hits.

    Args:
        network: A pretrained network, which reads which aliens are left.
        demonstrations: What it reads off each perfect demonstration, float32 (T + 1, n_features).
    """

    def __init__(self, network: RewardNetwork, demonstrations: Sequence[Tensor]) -> None:
        self._network = network
        self._states = torch.cat([one[:, :N_ALIENS] for one in demonstrations])
        left = torch.stack([one[-1, :N_ALIENS] > _STANDING for one in demonstrations])
        self.aliens = torch.nonzero(left.all(0))[:, 0]
        """Indices of the aliens that are left in the end of all demonstrations, row by row."""

    def logits(self, count: int, length: int, rng: np.random.Generator) -> Tensor:
        """Return preference logits of drawn states and aliens, float32 (count,).

        Args:
            count: How many.
            length: Observations of a fragment that stays in such a state.
            rng: Source of the states and aliens.
        """
        states = self._states[torch.from_numpy(rng.integers(len(self._states), size=count))]
        chosen = self.aliens[torch.from_numpy(rng.integers(len(self.aliens), size=count))]
        without = states.clone()
        without[torch.arange(count), chosen] = 0.0
        device = self._network.output.weight.device
        better, worse = (
            self._network.from_features(self._network.features_of(flags).to(device))
            for flags in (states, without)
        )
        return length * (better - worse)
