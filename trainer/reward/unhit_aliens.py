"""What no perfect demonstration does: hitting aliens that all of them leave standing.

A dozen games of a behaviour show few of the thirty aliens that it does not ask for being hit. How
the others count would be left to chance: R of an alien that nobody hits can be of either sign, and
an imitator finds those that pay. So states of perfect demonstrations are preferred to the same
states with one more of these aliens gone. Nobody plays such games; a pretrained network's R is
linear in which aliens are left, so that what it would read off their screens is known. Which aliens
a demonstration hits is what its replay tells: screens show it some steps later, if time is left.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import torch
from torch import Tensor

from trainer.nn.devices import device_of
from trainer.reward.model import RewardNetwork
from tril.game.space_invaders import COLUMNS, ROWS


class UnhitAliens:
    """States of perfect demonstrations, and the same without an alien that none of these hits.

    Args:
        network: A pretrained network, which reads which aliens are left.
        demonstrations: What it reads off each perfect demonstration, float32 (T + 1, n_features).
        unhit: Aliens that none of them hits, row by row from 0 on, at least one.
    """

    def __init__(
        self, network: RewardNetwork, demonstrations: Sequence[Tensor], unhit: Sequence[int]
    ) -> None:
        self._network = network
        self._states = torch.cat([one[:, : ROWS * COLUMNS] for one in demonstrations])
        self._unhit = torch.tensor(unhit)

    def logits(self, count: int, length: int, rng: np.random.Generator) -> Tensor:
        """Return preference logits of drawn states and aliens, float32 (count,).

        Args:
            count: How many.
            length: Observations of a fragment that stays in such a state.
            rng: Source of the states and aliens.
        """
        states = self._states[torch.from_numpy(rng.integers(len(self._states), size=count))]
        aliens = self._unhit[torch.from_numpy(rng.integers(len(self._unhit), size=count))]
        without = states.clone()
        without[torch.arange(count), aliens] = 0.0
        device = device_of(self._network)
        better, worse = (
            self._network.from_features(self._network.features_of(one).to(device))
            for one in (states, without)
        )
        return length * (better - worse)
